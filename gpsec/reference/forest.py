"""The isolation forest by its definition (Liu, Ting and Zhou, ICDM 2008)."""

from collections import deque
from collections.abc import Sequence
from math import log
from typing import Self

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.detection.isolation_forest import WINDOW
from gpsec.detection.learned import Learned
from gpsec.reference.detector import Scale, TrackDetector
from gpsec.reference.sight import Sight


def expected_path(samples: int) -> float:
    """Return c(n) = 2·H(n - 1) - 2·(n - 1)/n, with H(i) ≈ ln(i) + γ: the path of an unsuccessful search (Eq 1)."""
    if samples <= 2:
        return float(samples == 2)
    return 2.0 * (log(samples - 1) + np.euler_gamma) - 2.0 * (samples - 1) / samples


class PlainForest:
    """Trees as plain lists; shared by all tracks."""

    def __init__(self, learned: Learned) -> None:
        self._root: list[int] = learned["root"].tolist()
        self._feature: list[int] = learned["feature"].tolist()
        self._threshold: list[float] = learned["threshold"].tolist()
        self._child: list[int] = learned["child"].tolist()
        self._count: list[int] = learned["count"].tolist()
        self._samples = int(learned["samples"])
        self._rest = {count: expected_path(count) for count in set(self._count)}

    def score(self, features: Sequence[float] | Floats) -> float:
        """Return 2^(-E[path]/c(samples)); features are float32, as scikit-learn takes them."""
        values = np.asarray(features, np.float32).tolist()
        mean = sum(self._path(root, values) for root in self._root) / len(self._root)
        return float(2.0 ** (-mean / expected_path(self._samples)))

    def _path(self, node: int, values: list[float]) -> float:
        """Return how many cuts lead to the leaf, plus those that the samples left in it would have taken."""
        cuts = 0
        while self._feature[node] >= 0:
            right = values[self._feature[node]] > self._threshold[node]
            node = self._child[node] + right
            cuts += 1
        return cuts + self._rest[self._count[node]]

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        return self


class TrackForest(TrackDetector):
    """Isolation forest on windows of the residual."""

    def __init__(self, forest: PlainForest, scale: Scale) -> None:
        super().__init__(scale)
        self._forest = forest
        self._last: deque[float] = deque(maxlen=WINDOW)

    def forget(self) -> None:
        """Empty the window."""
        self._last.clear()

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the anomaly score of the window and its mean, turned so that the mean is not negative."""
        self._last.append(z)
        if len(self._last) < WINDOW:
            return None
        side = -1.0 if sum(self._last) < 0.0 else 1.0
        features = [side * value for value in self._last]
        features.append(sum(features) / WINDOW)
        return self._forest.score(np.clip(features, -1e6, 1e6))
