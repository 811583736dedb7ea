"""An isolation forest as flat arrays, scored by a kernel that equals scikit-learn's `score_samples`."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gpsec.core.arrays import Floats, Floats32, Ints, Longs
from gpsec.core.errors import GpsecError
from gpsec.core.kernels import allocating_kernel, inline
from gpsec.detection.learned import Learned, array_of

# Rows that go through a tree side by side. It stays in the fastest cache meanwhile, and no row waits for another: a
# processor can foresee neither a branch nor the next node, but it can look up many of them at once.
TREE_BLOCK = 1024
# Trees are stored with all nodes down to the deepest leaf. Training makes none deeper than 10.
DEEPEST = 12
# Room for the features of a row; a power of two makes it cheap to find them.
WIDTH = 8


class Forest(NamedTuple):
    """The trees of P profiles, T each, with all nodes down to depth d.

    Node q has the children 2q and 2q + 1, and the root is node 1. What would be below a leaf leads on to the same path
    length as the leaf.

    Attributes:
        feature: (P, T, 2**d) that a node asks for.
        threshold: (P, T, 2**d) goes left where the feature is at most that.
        path: (P, T, 2**d) path length that the nodes after the last level, from 2**d on, stand for.
        depth: d.
        scale: (P,) negative reciprocal of the path length at which the score is 1/2, summed over trees.
    """

    feature: NDArray[np.uint8]
    threshold: Floats32
    path: Floats
    depth: int
    scale: Floats


class Walkers(NamedTuple):
    """Up to `TREE_BLOCK` rows on their way through a forest.

    Attributes:
        features: (TREE_BLOCK, WIDTH) of which the forest asks for F.
        node: (TREE_BLOCK,) where they are.
        score: (TREE_BLOCK,) path lengths of the trees so far, and in the end the scores.
    """

    features: Floats32
    node: NDArray[np.uint32]
    score: Floats


class _Trees(NamedTuple):
    """The (T,) trees of one profile, their nodes in one list."""

    root: Ints
    feature: Ints
    threshold: Floats32
    child: Ints
    path: Floats
    depth: int
    scale: float


def average_path(count: Floats) -> Floats:
    """Return the average path length of an unsuccessful search in a binary tree of (…) `count` samples.

    c(n) = 2·(ln(n - 1) + γ) - 2·(n - 1)/n, c(2) = 1, c(1) = 0. Source: Liu, Ting and Zhou, "Isolation Forest",
    ICDM 2008, Eq 1.
    """
    n = np.maximum(count, 2.0)
    above = 2.0 * (np.log(np.maximum(n - 1.0, 1.0)) + np.euler_gamma) - 2.0 * (n - 1.0) / n
    return np.where(count <= 1.0, 0.0, np.where(count <= 2.0, 1.0, above))


def join(learned: Sequence[Learned], features: int) -> Forest:
    """Return the forests of several profiles as one; each must ask for fewer than `features` features.

    Raises:
        GpsecError: an array is missing or damaged, or the numbers of trees differ.
    """
    forests = [_read(one, features) for one in learned]
    counts = {len(one.root) for one in forests}
    if len(counts) != 1:
        raise GpsecError(f"model of the isolation forest: expected one number of trees, found {sorted(counts)}")
    depth = max(one.depth for one in forests)
    feature, threshold, path = zip(*(_complete(one, depth) for one in forests), strict=True)
    scale = np.asarray([one.scale for one in forests])
    return Forest(np.stack(feature), np.stack(threshold), np.stack(path), depth, scale)


def _read(learned: Learned, features: int) -> _Trees:
    root, samples = array_of(learned, "root", np.int32, 1), array_of(learned, "samples", np.int32, 0)
    feature, child = array_of(learned, "feature", np.int32, 1), array_of(learned, "child", np.int32, 1)
    threshold, count = array_of(learned, "threshold", np.float32, 1), array_of(learned, "count", np.int32, 1)
    depth = _depths(root, feature, child, (threshold, count), features)
    _check_counts(root, np.flatnonzero(feature >= 0), child.astype(np.int64), count.astype(np.int64), int(samples))
    path = depth + average_path(count.astype(np.float64))
    scale = -1.0 / (len(root) * average_path(np.asarray([float(samples)]))[0])
    return _Trees(root, feature, threshold, child, path, int(depth.max()), float(scale))


def _depths(root: Ints, feature: Ints, child: Ints, others: tuple[NDArray[Any], ...], features: int) -> Longs:
    """Return how many steps (n,) each node is from its root.

    Raises:
        GpsecError: the nodes do not form trees, of which each node has its place in one, or one of them is too deep.
    """
    size, inner = len(feature), feature >= 0
    same = {len(array) for array in (child, *others)} == {size}
    # Children come after their parent, so that a walk always ends.
    ordered = same and bool((child[inner] > np.flatnonzero(inner)).all() and (child[inner] < size - 1).all())
    if not (ordered and len(root) and (feature < features).all() and (root >= 0).all() and (root < size).all()):
        raise GpsecError("model of the isolation forest: its nodes do not form trees")
    depth, level = np.full(size, -1), root
    for steps in range(DEEPEST + 1):
        if (depth[level] >= 0).any() or len(np.unique(level)) < len(level):
            raise GpsecError("model of the isolation forest: its nodes do not form trees: one has two parents")
        depth[level] = steps
        first = child[level[inner[level]]]
        level = np.concatenate([first, first + 1])
    if len(level) or (depth < 0).any():
        raise GpsecError(f"model of the isolation forest: expected trees of at most {DEEPEST} levels, and nothing else")
    return depth


def _check_counts(root: Ints, inner: Longs, child: Longs, count: Longs, samples: int) -> None:
    """Refuse trees whose nodes do not share out the samples that they were made of."""
    shared = count[child[inner]] + count[child[inner] + 1]
    if samples < 2 or (count < 1).any() or (count[root] != samples).any() or (count[inner] != shared).any():
        raise GpsecError("model of the isolation forest: its nodes do not share out the samples of each tree")


def _complete(trees: _Trees, depth: int) -> tuple[NDArray[np.uint8], Floats32, Floats]:
    """Return (T, 2**depth) feature, threshold and path; see `Forest`."""
    feature = np.zeros((len(trees.root), 2**depth), np.uint8)
    threshold = np.full(feature.shape, np.inf, np.float32)
    level = trees.root[:, None]
    for first in (2**d for d in range(depth)):
        inner = trees.feature[level] >= 0
        feature[:, first : 2 * first][inner] = trees.feature[level[inner]]
        threshold[:, first : 2 * first][inner] = trees.threshold[level[inner]]
        left = np.where(inner, trees.child[level], level)
        level = np.stack([left, left + inner], axis=2).reshape(len(level), -1)
    return feature, threshold, trees.path[level]


@inline
def walk(forest: Forest, profile: int, walkers: Walkers, count: int) -> None:
    """Give the first `count` walkers their anomaly scores in (0, 1]: 2 to the power of -(mean path)/c(samples).

    All take one step down, and then the next. Nodes are unsigned, which spares every look-up a test for indices that
    count from the end.
    """
    node, score = walkers.node, walkers.score
    for n in range(count):
        score[n] = 0.0
    for t in range(forest.path.shape[1]):
        for n in range(count):
            node[n] = 1
        for _ in range(forest.depth):
            for n in range(count):
                q = node[n]
                right = walkers.features[n, forest.feature[profile, t, q]] > forest.threshold[profile, t, q]
                node[n] = q + q + np.uint32(right)
        for n in range(count):
            score[n] += forest.path[profile, t, node[n] - np.uint32(forest.path.shape[2])]
    for n in range(count):
        score[n] = 2.0 ** (score[n] * forest.scale[profile])


@allocating_kernel
def score(forest: Forest, profile: int, features: Floats32) -> Floats:
    """Return the anomaly scores of (n, F) vectors of features: the negative of scikit-learn's `score_samples`."""
    scores = np.empty(len(features))
    block = Walkers(np.empty((TREE_BLOCK, WIDTH), np.float32), np.empty(TREE_BLOCK, np.uint32), np.empty(TREE_BLOCK))
    for start in range(0, len(features), TREE_BLOCK):
        count = min(TREE_BLOCK, len(features) - start)
        block.features[:count, : features.shape[1]] = features[start : start + count]
        walk(forest, profile, block, count)
        scores[start : start + count] = block.score[:count]
    return scores
