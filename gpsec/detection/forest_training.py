"""Trains the isolation forest with scikit-learn and flattens it."""

from collections.abc import Sequence

import numpy as np
from sklearn.ensemble import IsolationForest as SklearnForest

from gpsec.core.arrays import Floats, Floats32, Ints, Longs
from gpsec.core.kernels import allocating_kernel
from gpsec.detection.alarm import GAP_S, steps_in
from gpsec.detection.isolation_forest import FEATURES, WINDOW, describe
from gpsec.detection.learned import Learned, OnStage, silent
from gpsec.detection.logs import Grid, ResidualLog, sessions
from gpsec.detection.ring import push

TREES = 32
SAMPLES = 1024
MAX_FOREST_WINDOWS = 200_000


def learn_forest(logs: Sequence[ResidualLog], seed: int, progress: OnStage = silent) -> Learned:
    """Return the arrays of a forest that was fitted to benign windows; see `forest.join`."""
    progress("training isolation_forest", 0, 1)
    fitted = fit(windows(Grid.of(logs)), seed)
    progress("training isolation_forest", 1, 1)
    return flatten(fitted)


def windows(grid: Grid) -> Floats32:
    """Return the (n, F) features of every full window in a grid."""
    pieces = []
    for vehicle, steps in sessions(grid, steps_in(GAP_S, grid.step_s)):
        if len(steps) >= WINDOW:
            pieces.append(_describe_all(grid.residual_m[steps, vehicle] / grid.scale_m[vehicle]))
    return np.concatenate(pieces) if pieces else np.zeros((0, len(FEATURES)), np.float32)


@allocating_kernel
def _describe_all(residual: Floats) -> Floats32:
    features = np.zeros((len(residual) - WINDOW + 1, len(FEATURES)), np.float32)
    window = np.zeros((1, WINDOW))
    count = np.zeros(1, np.int32)
    for t in range(len(residual)):
        if push(window, count, 0, residual[t]):
            describe(window, count, 0, features, t - WINDOW + 1)
    return features


def fit(features: Floats32, seed: int) -> SklearnForest:
    """Return scikit-learn's forest on at most `MAX_FOREST_WINDOWS` of the (n, F) windows."""
    if len(features) > MAX_FOREST_WINDOWS:
        features = features[np.random.default_rng(seed).choice(len(features), MAX_FOREST_WINDOWS, replace=False)]
    forest = SklearnForest(n_estimators=TREES, max_samples=min(SAMPLES, len(features)), random_state=seed, n_jobs=1)
    return forest.fit(features)


def flatten(forest: SklearnForest) -> Learned:
    """Return the arrays of a fitted forest.

    Features are float32, so a threshold may be rounded down to float32: the same values lie on each side of it.
    """
    roots: list[int] = []
    pieces: dict[str, list[Ints | Floats32]] = {"feature": [], "threshold": [], "child": [], "count": []}
    offset = 0
    for estimator in forest.estimators_:
        tree = estimator.tree_
        order, child = _breadth_first(tree.children_left, tree.children_right)
        leaf = tree.children_left[order] < 0
        rounded = tree.threshold.astype(np.float32)
        above = rounded.astype(np.float64) > tree.threshold
        rounded[above] = np.nextafter(rounded[above], np.float32(-np.inf))
        roots.append(offset)
        pieces["feature"].append(np.where(leaf, -1, tree.feature[order]).astype(np.int32))
        pieces["threshold"].append(np.where(leaf, np.float32(0.0), rounded[order]))
        pieces["child"].append(np.where(leaf, 0, child + offset).astype(np.int32))
        pieces["count"].append(tree.n_node_samples[order].astype(np.int32))
        offset += len(order)
    return {
        "root": np.asarray(roots, np.int32),
        "samples": np.asarray(forest.max_samples_, np.int32),
        **{key: np.concatenate(arrays) for key, arrays in pieces.items()},
    }


def _breadth_first(left: Longs, right: Longs) -> tuple[Longs, Longs]:
    """Return the nodes in breadth-first order, in which siblings are neighbours, and the new left child of each."""
    order, child = [0], []
    for node in order:  # grows while it is walked through
        child.append(len(order))
        if left[node] >= 0:
            order += [int(left[node]), int(right[node])]
    return np.asarray(order), np.asarray(child)
