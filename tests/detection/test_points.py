"""Operating points of one detector answer as so many detectors that do not know of each other."""

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.detection.base import Observation
from gpsec.detection.channels import Channels, silent_channels
from gpsec.detection.models import ProfileModel, build_detectors
from gpsec.detection.points import Watch
from gpsec.detection.registry import DETECTORS
from gpsec.types.answers import Answers
from gpsec.types.points import HOLD_S

NAMES = [name for name in DETECTORS if DETECTORS[name].threshold is None]
_SILENT = silent_channels((1,))
ROWS, STEPS, STEP_S = 24, 900, 0.1


def channels(random: np.random.Generator, count: int) -> Channels:
    """Return a monitor that says anything."""
    drawn = (random.random(count) < 0.9 if a.dtype == np.bool_ else random.exponential(1.0, count) for a in _SILENT)
    return Channels._make(drawn)


def observations(seed: int) -> list[Observation]:
    """Return steps of rows with attacks, junctions, and rows that are not observed."""
    random = np.random.default_rng(seed)
    residual = random.normal(0.0, 0.15, (STEPS, ROWS))
    for row in range(0, ROWS, 2):
        begin, length = random.integers(100, 600), random.integers(20, 200)
        residual[begin : begin + length, row] += random.choice([-1.0, 1.0]) * random.uniform(0.2, 2.0)
    valid = random.random((STEPS, ROWS)) > 0.02
    for row in range(ROWS):
        for begin in random.integers(50, STEPS, 4):
            valid[begin : begin + random.integers(5, int(3.0 * HOLD_S / STEP_S)), row] = False
    last = np.full(ROWS, -1)
    found = []
    for step in range(STEPS):
        rows = np.flatnonzero(random.random(ROWS) > 0.01).astype(np.int32)
        found.append(
            Observation(
                rows=rows,
                profile=np.zeros(len(rows), np.int32),
                residual_m=np.where(valid[step, rows], residual[step, rows], 0.0),
                valid=valid[step, rows],
                elapsed_steps=(step - last[rows]).astype(np.int32),
                scale_m=np.full(len(rows), 0.15),
                speed_mps=np.full(len(rows), 10.0),
                curvature_per_m=np.zeros(len(rows)),
                camera_sigma_m=np.full(len(rows), 0.05),
                unmatched=np.zeros(len(rows), np.bool_),
                channels=channels(random, len(rows)),
                step_s=STEP_S,
            )
        )
        last[rows[valid[step, rows]]] = step
    return found


@pytest.mark.parametrize("name", NAMES)
def test_points_do_as_alone(name: str, model: ProfileModel) -> None:
    (detector,) = build_detectors([name], ["carla"], "tracked", {("carla", "tracked"): model})
    steps = observations(seed=len(name))
    answers = Table(Answers, ROWS, detectors=1, defences=0).now
    state, seen = detector.new_state(ROWS).now, []
    for step in steps:
        detector.update(state, step, np.full(len(step.rows), np.inf), answers, 0)
        seen.append(answers.statistic[step.rows, 0].copy())
    # The statistic of most steps, of one in a hundred, and of one in a thousand.
    thresholds = np.quantile(np.concatenate(seen), [0.999, 0.5, 0.99])
    together = Table(Answers, ROWS, detectors=3, defences=0).now
    alone = Table(Answers, ROWS, detectors=3, defences=0).now
    watch = Watch(detector, [0, 1, 2])
    for table in watch.states():
        table.grow(ROWS)
    alarmed = np.zeros((ROWS, 3), np.bool_)
    states = [detector.new_state(ROWS).now for _ in thresholds]
    for step in steps:
        watch.update(step, np.tile(thresholds, (len(step.rows), 1)), together)
        for k, threshold in enumerate(thresholds):
            detector.update(states[k], step, np.full(len(step.rows), threshold), alone, k)
        for mine, theirs in zip(together, alone, strict=True):
            np.testing.assert_array_equal(mine, theirs)
        alarmed |= alone.alarm
    assert alarmed[:, 1:].any(axis=0).all()


def test_points_share_a_state_again_behind_a_gap() -> None:
    (detector,) = build_detectors(["cusum"], ["carla"], "tracked")
    watch = Watch(detector, [0, 1])
    answers = Table(Answers, 1, detectors=2, defences=0).now
    parted = []
    for residual_m, elapsed in [(0.0, 1), (3.0, 1), (3.0, 1), (0.0, 1), (0.0, 80), (0.0, 1)]:
        step = Observation(
            *(np.zeros(1, np.int32), np.zeros(1, np.int32), np.full(1, residual_m), np.ones(1, np.bool_)),
            *(np.full(1, elapsed, np.int32), np.full(1, 0.15), np.zeros(1), np.zeros(1), np.full(1, 0.05)),
            *(np.zeros(1, np.bool_), silent_channels((1,)), STEP_S),
        )
        # An alarm that is held when the gap begins would keep them apart.
        answers.alarm[:] &= elapsed == 1
        if elapsed > 1:
            for table in watch.states()[1:]:
                table.reset(np.zeros(1, np.int32))
        watch.update(step, np.array([[4.0, 1e9]]), answers)
        parted.append(bool(watch.states()[0].now.parted[0]))
    assert parted == [False, True, True, True, False, False]
