"""An isolation forest as flat arrays, scored by a kernel that equals scikit-learn's `score_samples`."""

from collections.abc import Sequence
from typing import NamedTuple, cast

import numpy as np

from gpsec.arrays import Floats, Floats32, Ints
from gpsec.detection.learned import Learned, part
from gpsec.errors import GpsecError
from gpsec.kernels import allocating_kernel, inline


class Forest(NamedTuple):
    """The trees of P profiles, T each; all nodes in one list.

    Attributes:
        root: (P, T) first node of each tree.
        feature: (Q,) that a node asks for.
        threshold: (Q,) goes left where the feature is at most that; infinite at a leaf.
        child: (Q,) left child of a node, the right one is next to it; a leaf is its own.
        path: (Q,) path length that a leaf stands for.
        depth: of the deepest leaf.
        scale: (P,) negative reciprocal of the path length at which the score is 1/2, summed over trees.
    """

    root: Ints
    feature: Ints
    threshold: Floats32
    child: Ints
    path: Floats
    depth: int
    scale: Floats


def average_path(count: Floats) -> Floats:
    """Return the average path length of an unsuccessful search in a binary tree of (…) `count` samples.

    c(n) = 2·(ln(n - 1) + γ) - 2·(n - 1)/n, c(2) = 1, c(1) = 0. Source: Liu, Ting and Zhou, "Isolation Forest",
    ICDM 2008, Eq 1.
    """
    n = np.maximum(count, 2.0)
    above = 2.0 * (np.log(np.maximum(n - 1.0, 1.0)) + np.euler_gamma) - 2.0 * (n - 1.0) / n
    return np.where(count <= 1.0, 0.0, np.where(count <= 2.0, 1.0, above))


def join(learned: Sequence[Learned], features: int) -> Forest:
    """Put the forests of several profiles behind one another; each must ask for fewer than `features` features.

    Raises:
        GpsecError: an array is missing or damaged, or the numbers of trees differ.
    """
    roots: list[Ints] = []
    nodes: list[tuple[np.ndarray, ...]] = []
    scales: list[float] = []
    offset, deepest = 0, 0
    for one in learned:
        root = part(one, "root", np.int32, 1)
        feature = part(one, "feature", np.int32, 1)
        size = len(feature)
        threshold = part(one, "threshold", np.float32, 1)
        child = part(one, "child", np.int32, 1)
        count = part(one, "count", np.int32, 1)
        inner = feature >= 0
        same = {len(threshold), len(child), len(count)} == {size}
        # Children come after their parent, so that a walk always ends.
        ordered = same and (child[inner] > np.flatnonzero(inner)).all() and (child[inner] + 1 < size).all()
        if not (ordered and (feature < features).all() and (root >= 0).all() and (root < size).all()):
            raise GpsecError("model of the isolation forest: its nodes do not form trees")
        if len(root) % 4 or (roots and len(root) != len(roots[0])):
            wanted = len(roots[0]) if roots else "a multiple of 4"
            raise GpsecError(f"model of the isolation forest: expected {wanted} trees, found {len(root)}")
        depth = np.zeros(size)
        for node in np.flatnonzero(inner):
            depth[child[node] : child[node] + 2] = depth[node] + 1.0
        path = depth + average_path(count.astype(np.float64))
        deepest = max(deepest, int(depth.max()))
        samples = average_path(np.asarray([float(part(one, "samples", np.int32, 0))]))[0]
        roots.append(root + offset)
        own = np.arange(size)
        walk = np.where(inner, feature, 0), np.where(inner, threshold, np.inf), np.where(inner, child, own) + offset
        nodes.append((*walk, path))
        scales.append(-1.0 / (len(root) * samples))
        offset += size
    joined = [np.concatenate(column) for column in zip(*nodes, strict=True)]
    return Forest(
        root=cast("Ints", np.stack(roots).astype(np.int32)),
        feature=joined[0].astype(np.int32),
        threshold=joined[1].astype(np.float32),
        child=joined[2].astype(np.int32),
        path=joined[3],
        depth=deepest,
        scale=np.asarray(scales),
    )


@inline
def _next(forest: Forest, node: int, features: Floats32) -> int:
    return int(forest.child[node] + np.int32(features[forest.feature[node]] > forest.threshold[node]))


@inline
def score_one(forest: Forest, profile: int, features: Floats32) -> float:
    """Return the anomaly score in (0, 1] of one vector of features: 2 to the power of -(mean path)/c(samples).

    Four trees are walked side by side, for as many steps as the deepest leaf has above it and without a branch on the
    way: a processor can foresee neither a branch nor the next node, but it can wait for four of them at once.
    """
    total = 0.0
    for t in range(0, forest.root.shape[1], 4):
        a, b = forest.root[profile, t], forest.root[profile, t + 1]
        c, d = forest.root[profile, t + 2], forest.root[profile, t + 3]
        for _ in range(forest.depth):
            a, b = _next(forest, a, features), _next(forest, b, features)
            c, d = _next(forest, c, features), _next(forest, d, features)
        total += forest.path[a]
        total += forest.path[b]
        total += forest.path[c]
        total += forest.path[d]
    return float(2.0 ** (total * forest.scale[profile]))


@allocating_kernel
def score(forest: Forest, profile: int, features: Floats32) -> Floats:
    """Return the anomaly scores of (n, F) vectors of features: the negative of scikit-learn's `score_samples`."""
    scores = np.empty(len(features))
    for i in range(len(features)):
        scores[i] = score_one(forest, profile, features[i])
    return scores
