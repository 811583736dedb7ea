"""What two engines have in common: the batched kernels (`gpsec.pipeline`) and the reference (`gpsec.reference`)."""

from collections import defaultdict
from dataclasses import dataclass
from time import perf_counter
from typing import Protocol, Self

import numpy as np

from gpsec.arrays import Flags, Floats, Ints
from gpsec.detection.base import Detector, LabelledDetector
from gpsec.detection.pairing import Sampling
from gpsec.fleet import Measurements, Rows, Tracks, Vehicles
from gpsec.kernels import compile_seconds
from gpsec.threads import Threads


class Stopwatch:
    """Adds up wall-clock seconds by stage.

    Attributes:
        stages_s: seconds of each stage so far, in the order in which stages were first entered.
        compile_s: seconds that went into compiling kernels; they count for no stage.
    """

    def __init__(self) -> None:
        self.stages_s: dict[str, float] = defaultdict(float)
        self.compile_s = 0.0
        self.start()

    def start(self) -> None:
        """Begin to count, whatever went on before."""
        self._since = perf_counter()
        self._compiled_s = compile_seconds()

    def lap(self, stage: str) -> None:
        """Count the time since `start` or the last lap for `stage`."""
        since, compiled_s = self._since, self._compiled_s
        self.start()
        compiled_s = self._compiled_s - compiled_s
        self.compile_s += compiled_s
        self.stages_s[stage] += self._since - since - compiled_s


@dataclass
class Answers(Rows):
    """What K detectors and D defences say of M tracks after a step.

    Attributes:
        statistic, scored, alarm: (M, K) of the detectors.
        estimate_m: (M, D, 2) of the rear axle in the net's frame.
        isolated: (M, D) GNSS is not used.

    """

    statistic: Floats
    scored: Flags
    alarm: Flags
    estimate_m: Floats
    isolated: Flags

    @classmethod
    def empty(cls, capacity: int, detectors: int, defences: int) -> Self:
        """Return `capacity` rows without an answer."""
        return cls(
            statistic=np.zeros((capacity, detectors)),
            scored=np.zeros((capacity, detectors), np.bool_),
            alarm=np.zeros((capacity, detectors), np.bool_),
            estimate_m=np.zeros((capacity, defences, 2)),
            isolated=np.zeros((capacity, defences), np.bool_),
        )


class Method(Protocol):
    """Residual, detectors and filters of every track.

    Attributes:
        answers: what was found in the last step.

    """

    answers: Answers

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        ...

    def reset(self, rows: Ints) -> None:
        """Begin anew in `rows`."""
        ...

    def copy(self, source: Ints, target: Ints) -> None:
        """Let the tracks `target` go on from where the tracks `source` are."""
        ...

    def step(
        self,
        number: int,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
        watch: Stopwatch,
    ) -> None:
        """Take step `number` (from 0) of the track rows `rows`; sets residuals in `tracks` and `answers`."""
        ...


@dataclass(frozen=True)
class Watchers:
    """The detectors of a run.

    Attributes:
        names: of the K detectors.
        detectors: themselves.
        thresholds: (profiles, K).
        scale_m: (profiles,) standard deviation of the residual that each profile promises.
        sampling: how old samples may be of which a residual is formed.

    """

    names: tuple[str, ...]
    detectors: tuple[Detector | LabelledDetector, ...]
    thresholds: Floats
    scale_m: Floats
    sampling: Sampling
