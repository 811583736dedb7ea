import numpy as np
import pytest
from sklearn.ensemble import IsolationForest as SklearnForest

from gpsec.core.errors import GpsecError
from gpsec.detection import forest_training
from gpsec.detection.forest import DEEPEST, average_path, join, score
from gpsec.detection.isolation_forest import FEATURES, WINDOW, IsolationForest
from gpsec.detection.logs import Grid
from gpsec.testing.detector_bench import Bench
from gpsec.testing.residuals import make_log


@pytest.fixture(scope="module")
def fitted():
    grid = Grid.of([make_log(30, 300, seed=2)])
    forest = SklearnForest(n_estimators=12, max_samples=512, random_state=4)
    return forest.fit(forest_training.windows(grid))


def test_score_equals_score_samples(fitted, rng):
    kernel = join([forest_training.flatten(fitted)], len(FEATURES))
    # Values on the thresholds themselves as well: there the rounding to float32 matters.
    samples = rng.normal(scale=2.0, size=(3000, len(FEATURES))).astype(np.float32)
    tree = fitted.estimators_[0].tree_
    inner = np.flatnonzero(tree.feature >= 0)
    for row, node in enumerate(inner[:200]):
        samples[row, tree.feature[node]] = tree.threshold[node]
    assert np.abs(score(kernel, 0, samples) + fitted.score_samples(samples)).max() < 1e-12


def test_second_profile_uses_its_own_trees(fitted, rng):
    other = SklearnForest(n_estimators=12, max_samples=100, random_state=1).fit(rng.normal(size=(500, len(FEATURES))))
    both = join([forest_training.flatten(fitted), forest_training.flatten(other)], len(FEATURES))
    samples = rng.normal(size=(200, len(FEATURES))).astype(np.float32)
    for profile, forest in enumerate((fitted, other)):
        assert np.abs(score(both, profile, samples) + forest.score_samples(samples)).max() < 1e-12


def test_detector_scores_windows_as_scikit_learn_does(fitted):
    grid = Grid.of([make_log(1, 60, seed=8, gaps=False)])
    detector = IsolationForest.from_learned([forest_training.flatten(fitted)])
    bench = Bench(detector, 1)
    got = [bench.ask(grid.observe(t), np.ones(1)).statistic[0] for t in range(60)]
    assert got[: WINDOW - 1] == [0.0] * (WINDOW - 1)
    u = grid.residual_m[:, 0] / grid.scale_m[0]
    for t in range(WINDOW - 1, 60):
        window = u[t - WINDOW + 1 : t + 1]
        window = -window if window.sum() < 0.0 else window
        features = np.append(window, window.mean())[None].astype(np.float32)
        assert abs(got[t] + fitted.score_samples(features)[0]) < 1e-12


def test_trees_of_any_depth_up_to_the_limit(rng):
    samples = np.sort(rng.normal(size=40)).astype(np.float32)
    for depth in (0, 1, DEEPEST):
        learned = _comb(samples, depth)
        got = score(join([learned], 1), 0, samples[:, None])
        # Sample k is cut off after k + 1 cuts, and those beyond the last cut stay together.
        cuts = np.minimum(np.arange(40) + 1.0, depth)
        rest = average_path(np.where(np.arange(40) < depth, 1.0, 40.0 - depth))
        assert np.allclose(got, 2.0 ** (-(cuts + rest) / average_path(np.asarray([40.0]))), rtol=1e-12)
    with pytest.raises(GpsecError, match="at most 12 levels"):
        join([_comb(samples, DEEPEST + 1)], 1)


def _comb(samples, depth):
    """Return one tree in which every cut leaves the smallest sample on the left, and the next cut on the right."""
    nodes = []
    for k in range(depth):
        nodes += [(0, samples[k], 2 * k + 1, 40 - k), (-1, 0.0, 0, 1)]
    nodes.append((-1, 0.0, 0, 40 - depth))
    feature, threshold, child, count = (np.asarray(column) for column in zip(*nodes, strict=True))
    return {
        "root": np.zeros(1, np.int32),
        "samples": np.asarray(40, np.int32),
        "feature": feature.astype(np.int32),
        "threshold": threshold.astype(np.float32),
        "child": child.astype(np.int32),
        "count": count.astype(np.int32),
    }


def test_forests_of_different_size_are_refused(fitted):
    small = SklearnForest(n_estimators=3, max_samples=32, random_state=1).fit(np.zeros((50, len(FEATURES))))
    with pytest.raises(GpsecError, match="one number of trees"):
        join([forest_training.flatten(fitted), forest_training.flatten(small)], len(FEATURES))


def test_average_path_by_hand():
    # c(3) = 2·(ln 2 + γ) - 4/3.
    assert average_path(np.asarray([1.0, 2.0, 3.0])).tolist() == pytest.approx(
        [0.0, 1.0, 2.0 * (0.6931471805599453 + 0.5772156649015329) - 4.0 / 3.0], abs=1e-12
    )


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("child", lambda a: np.zeros_like(a)),
        ("feature", lambda a: a + 100),
        ("threshold", lambda a: a[:-1]),
        ("threshold", lambda a: a.astype(np.float64)),
        ("threshold", lambda a: a * np.float32(np.nan)),
        ("root", lambda a: a[:3]),
    ],
)
def test_damaged_trees_are_refused(fitted, key, change):
    arrays = dict(forest_training.flatten(fitted))
    arrays[key] = change(arrays[key])
    with pytest.raises(GpsecError):
        IsolationForest.from_learned([arrays])


@pytest.mark.parametrize("key", ["child", "feature", "count", "samples", "root"])
@pytest.mark.parametrize("value", [-1, 0, 2**30, 2**31 - 1, -(2**31)])
@pytest.mark.parametrize("everywhere", [True, False])
def test_numbers_that_no_training_leaves_behind_are_refused(fitted, key, value, everywhere):
    arrays = {name: np.array(array) for name, array in forest_training.flatten(fitted).items()}
    if everywhere:
        arrays[key][...] = value
    else:
        # A node that has children.
        np.atleast_1d(arrays[key])[0] = value
        if arrays[key].ndim == 0:
            arrays[key][...] = value
    if all((arrays[name] == array).all() for name, array in forest_training.flatten(fitted).items()):
        return  # the first root, and what the first node asks for, may be 0
    if key == "feature" and value == 0 and not everywhere:
        return  # another feature is as good
    with pytest.raises(GpsecError):
        IsolationForest.from_learned([arrays])


def test_trees_that_share_a_node_or_go_in_circles_are_refused(fitted):
    for node in range(5):
        for other in range(0, 60, 7):
            arrays = {name: np.array(array) for name, array in forest_training.flatten(fitted).items()}
            if arrays["feature"][node] < 0 or arrays["child"][node] == other:
                continue
            arrays["child"][node] = other
            with pytest.raises(GpsecError, match=r"do not form trees|do not share out|levels"):
                IsolationForest.from_learned([arrays])
