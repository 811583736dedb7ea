import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.outcomes.state import (
    ATTACK,
    LIFE,
    LINE_TOUCHED,
    OFF_ROAD,
    OUT_OF_LANE,
    WRONG_WAY,
    OutcomeState,
    worst,
)
from gpsec.types.tracks import Tracks

from .scene import Scene, lane_sides


def play(scene, row, alarms, *, first_step=0, scored=None):
    """Observe one row while its first detector says `alarms`, a letter a step: A alarm, - none, . not scored."""
    for i, said in enumerate(alarms):
        scene.alarm[row, 0] = said == "A"
        scene.scored[row, 0] = said != "."
        scene.observe(first_step + i, [row])


def test_counts_and_onsets_of_a_forked_track():
    scene = Scene()
    scene.tracks.settled[0] = False
    play(scene, 0, "AAA")  # before settling: nothing counts
    scene.tracks.settled[0] = True
    play(scene, 0, "-A-A-", first_step=3)  # FP 2, TN 3, two false onsets
    scene.fork(0, 1, plan=1, step=8)
    play(scene, 1, "-.AA.A", first_step=8)  # FN 1, TP 3; step 12 drops the alarm without a score
    scene.end_attack(1, step=14)
    play(scene, 1, "A--A", first_step=14)  # a tail of 1, TN 2, FP 1, one more false onset

    counts, onsets = scene.state.counts[1, 0], scene.state.onsets[1, 0]
    np.testing.assert_array_equal(counts, [3, 2 + 1, 1, 3 + 2])
    assert scene.state.tail_end_step[1, 0] == 15
    np.testing.assert_array_equal(onsets, [2 + 2 + 1, 2 + 1])
    np.testing.assert_array_equal(scene.state.steps[1], [5 + 6 + 4, 6])
    assert scene.state.detection_step[1, 0] == 10
    assert not scene.state.in_alarm_at_start[1, 0]
    # The benign twin has not been touched since.
    np.testing.assert_array_equal(scene.state.counts[0, 0], [0, 2, 0, 3])
    assert scene.state.detection_step[0, 0] == -1
    # The detector that is never in alarm misses all that it scores.
    np.testing.assert_array_equal(scene.state.counts[1, 1], [0, 0, 6, 9])


def test_an_alarm_that_stands_when_the_attack_begins_detects_at_once_and_is_noted():
    scene = Scene()
    play(scene, 0, "-A")
    scene.fork(0, 1, plan=1, step=2)
    play(scene, 1, "AA", first_step=2)
    assert scene.state.detection_step[1, 0] == 2
    assert scene.state.in_alarm_at_start[1, 0]
    np.testing.assert_array_equal(scene.state.onsets[1, 0], [1, 1])


@pytest.mark.parametrize(("before", "first", "stood"), [("-", "A", False), ("A", "-", True), ("-", "-", False)])
def test_only_the_alarm_before_the_attack_stood_when_it_began(before, first, stood):
    """An alarm that is raised in the very step of the attack is a detection, and one that ends there did stand."""
    scene = Scene()
    play(scene, 0, before)
    scene.fork(0, 1, plan=1, step=1)
    play(scene, 1, first + "A", first_step=1)
    assert scene.state.in_alarm_at_start[1, 0] == stood
    assert scene.state.detection_step[1, 0] == (1 if first == "A" else 2)


def test_an_alarm_that_stands_at_settling_is_one_false_alarm():
    scene = Scene()
    scene.tracks.settled[0] = False
    play(scene, 0, "AA")
    scene.tracks.settled[0] = True
    play(scene, 0, "AA", first_step=2)
    np.testing.assert_array_equal(scene.state.onsets[0, 0], [1, 1])


def test_an_alarm_after_the_attack_does_not_detect_it():
    scene = Scene()
    scene.fork(0, 1, plan=1, step=0)
    play(scene, 1, "--")
    scene.end_attack(1, step=2)
    play(scene, 1, "A", first_step=2)
    assert scene.state.detection_step[1, 0] == -1


def test_errors_are_split_along_and_across_the_lane():
    scene = Scene()
    scene.vehicles.lane_yaw_rad[0] = np.pi / 2  # north: left is west
    scene.vehicles.rear_m[0] = 100.0, 200.0
    scene.estimate_m[0, 0] = 97.0, 204.0  # 3 m to the left, 4 m ahead
    scene.estimate_m[0, 1] = 101.0, 200.0  # 1 m to the right
    scene.observe(0, [0])
    np.testing.assert_allclose(scene.state.squared_m2[0, :, LIFE], [[9, 16, 9, 16], [1, 0, 1, 0]], atol=1e-12)
    np.testing.assert_allclose(scene.state.max_cross_m[0, :, LIFE], [3.0, 1.0])
    assert not scene.state.squared_m2[0, :, ATTACK].any()


def test_deviation_is_that_of_the_defence_in_the_step_of_detection():
    scene = Scene(defences=(("cusum", "ukf"), ("cusum", "none"), ("never", "none")))
    scene.fork(0, 1, plan=1, step=0)
    for step, (alarm, error) in enumerate([(False, 0.1), (True, 0.4), (True, 0.9)]):
        scene.alarm[1, 0] = alarm
        scene.estimate_m[1, :, 1] = error, -2 * error, 5 * error
        scene.observe(step, [1])
    np.testing.assert_allclose(scene.state.deviation_m[1], [0.4, 0.8, 0.0])


def test_what_goes_undetected_is_of_the_first_defence_before_the_first_alarm():
    scene = Scene()
    scene.estimate_m[0, 0, 1] = 7.0
    scene.observe(0, [0])  # before the attack
    scene.fork(0, 1, plan=1, step=1)
    for step, (alarm, error) in enumerate([(False, 0.1), (False, -0.3), (True, 0.4), (False, 0.9)], start=1):
        scene.alarm[1, 0] = alarm
        scene.estimate_m[1, :, 1] = error, 5.0
        scene.observe(step, [1])
    scene.end_attack(1, step=5)
    scene.estimate_m[1, 0, 1] = 8.0
    scene.observe(5, [1])
    np.testing.assert_allclose(scene.state.undetected_m[1], [0.3, 0.9])
    np.testing.assert_array_equal(scene.state.undetected_step[1], [2, 4])
    assert not scene.state.undetected_m[0].any()


def test_trust_returns_in_the_first_step_after_the_attack_that_uses_gnss():
    scene = Scene()
    scene.fork(0, 1, plan=1, step=0)
    scene.isolated[1] = True, False
    for step in range(3):
        scene.observe(step, [1])
    scene.end_attack(1, step=3)
    for step in range(3, 8):
        scene.isolated[1, 0] = step < 6
        scene.observe(step, [1])
    np.testing.assert_array_equal(scene.state.retrust_step[1], [6, 3])
    np.testing.assert_array_equal(scene.state.isolated_steps[1, :, ATTACK], [3, 0])


# Thresholds for a vehicle 2.11 m wide that were published for lanes of 2.7 m and 3.6 m with one oncoming lane.
@pytest.mark.parametrize(("lane_m", "touch_m", "wrong_way_m"), [(2.7, 0.295, 2.405), (3.6, 0.745, 2.855)])
def test_published_thresholds(lane_m, touch_m, wrong_way_m):
    def reached(error_m):
        scene = Scene(sides=lane_sides(lane_m, oncoming_left=lane_m, oncoming_right=0.0))
        scene.vehicles.width_m[:] = 2.11
        scene.estimate_m[0, 0, 1] = -error_m  # estimate to the right: the vehicle goes to the left
        scene.observe(0, [0])
        return scene.state.first_step[0, 0] == 0

    assert not reached(touch_m - 1e-9).any()
    np.testing.assert_array_equal(reached(touch_m + 1e-9), [True, False, False, False])
    np.testing.assert_array_equal(reached(lane_m / 2 - 1e-9), [True, False, False, False])
    np.testing.assert_array_equal(reached(lane_m / 2 + 1e-9), [True, True, False, False])
    np.testing.assert_array_equal(reached(wrong_way_m - 1e-9), [True, True, False, False])
    np.testing.assert_array_equal(reached(wrong_way_m + 1e-9), [True, True, True, False])
    np.testing.assert_array_equal(reached(wrong_way_m + lane_m + 1e-9), [True, True, True, True])


# A lane of 3 m, a vehicle of 2 m: half of both is 2.5 m. Two lanes more to the right, one oncoming to the left.
@pytest.mark.parametrize(
    ("error_m", "expected"),
    [
        (2.6, [LINE_TOUCHED, OUT_OF_LANE]),  # displaced to the right, into a lane of its own direction
        (8.4, [LINE_TOUCHED, OUT_OF_LANE]),
        (8.6, [LINE_TOUCHED, OUT_OF_LANE, OFF_ROAD]),
        (-2.4, [LINE_TOUCHED, OUT_OF_LANE]),
        (-2.6, [LINE_TOUCHED, OUT_OF_LANE, WRONG_WAY]),
        (-5.4, [LINE_TOUCHED, OUT_OF_LANE, WRONG_WAY]),
        (-5.6, [LINE_TOUCHED, OUT_OF_LANE, WRONG_WAY, OFF_ROAD]),
    ],
)
def test_the_side_counts_to_which_the_vehicle_would_go(error_m, expected):
    scene = Scene(sides=lane_sides(3.0, same_right=6.0, oncoming_left=3.0))
    scene.vehicles.width_m[:] = 2.0
    scene.estimate_m[0, 0, 1] = error_m
    scene.observe(0, [0])
    assert list(np.flatnonzero(scene.state.first_step[0, 0] == 0)) == expected


def test_no_outcome_inside_a_junction_or_off_the_map():
    inside = Scene(sides=lane_sides(internal=True))
    off = Scene()
    off.vehicles.lane[0] = -1
    for scene in (inside, off):
        scene.estimate_m[0, :, 1] = 50.0
        scene.observe(0, [0])
        assert (scene.state.first_step[0] == -1).all()
        assert scene.state.max_cross_m[0, 0, LIFE] == 50.0


def test_an_attack_answers_for_nothing_that_happened_before_it_but_for_all_after():
    scene = Scene()
    scene.estimate_m[:, 0, 1] = 2.0
    scene.observe(0, [0])
    assert scene.state.first_step[0, 0, OUT_OF_LANE] == 0
    scene.estimate_m[:, 0, 1] = 0.0
    scene.fork(0, 1, plan=1, step=1)
    scene.observe(1, [0, 1])
    assert scene.state.first_step[0, 0, OUT_OF_LANE] == 0
    assert (scene.state.first_step[1] == -1).all()
    scene.end_attack(1, step=2)
    scene.estimate_m[1, 0, 1] = 2.0
    scene.observe(2, [0, 1])
    assert scene.state.first_step[1, 0, OUT_OF_LANE] == 2
    assert scene.state.max_cross_m[1, 0, ATTACK] == 0.0


@pytest.mark.parametrize(
    ("first_steps", "expected"),
    [
        ([-1, -1, -1, -1], (-1, -1)),
        ([4, -1, -1, -1], (LINE_TOUCHED, 4)),
        ([4, 6, -1, -1], (OUT_OF_LANE, 6)),
        ([4, 6, 9, -1], (WRONG_WAY, 9)),
        ([4, 6, -1, 8], (OFF_ROAD, 8)),
        ([4, 6, 9, 12], (WRONG_WAY, 9)),
        ([4, 6, 9, 8], (OFF_ROAD, 8)),
        ([4, 4, 4, 4], (OFF_ROAD, 4)),
    ],
)
def test_worst_outcome(first_steps, expected):
    outcome, step = worst(np.array([first_steps], np.int32))
    assert (outcome[0], step[0]) == expected


def test_worst_keeps_the_shape():
    outcome, step = worst(np.full((3, 2, 4), -1, np.int32))
    assert outcome.shape == step.shape == (3, 2)
    assert worst(np.zeros((0, 2, 4), np.int32))[0].shape == (0, 2)


class Randomised:
    """Tracks that begin, are attacked and end at random, and the record of what they saw."""

    STEPS, ROWS, SIDES = 80, 30, lane_sides(3.2, same_left=3.2, oncoming_left=3.2, oncoming_right=3.2)

    def __init__(self, rows=ROWS, seed=5):
        self.rng = rng = np.random.default_rng(seed)
        self.scene = scene = Scene(capacity=rows, sides=self.SIDES)
        self.rows = rows
        scene.tracks.plan[:] = np.arange(rows) % 2
        self.settle = rng.integers(0, 20, rows)
        start = rng.integers(20, 50, rows)
        scene.tracks.start_step[:] = np.where(scene.tracks.plan == 1, start, -1)
        self.end = start + rng.integers(5, 60, rows)
        scene.vehicles.width_m[:] = rng.uniform(1.6, 2.6, rows)
        self.history = []

    def step(self, step, order=None, threads=None):
        scene, rng, rows = self.scene, self.rng, self.rows
        tracks, vehicles = scene.tracks, scene.vehicles
        planned = tracks.plan == 1
        tracks.settled[:] = step >= self.settle
        tracks.attacked[:] = planned & (step >= tracks.start_step) & (step < self.end)
        tracks.end_step[:] = np.where(planned & (step >= self.end), self.end, -1)
        vehicles.rear_m[:] = rng.normal(0, 1000, (rows, 2))
        vehicles.lane_yaw_rad[:] = rng.uniform(-np.pi, np.pi, rows)
        scene.estimate_m[:] = vehicles.rear_m[:, None] + rng.normal(0, 0.1 * step, (rows, 2, 2))
        scene.statistic[:] = rng.exponential(1.0, (rows, 2))
        scene.scored[:] = rng.random((rows, 2)) < 0.8
        scene.alarm[:] = rng.random((rows, 2)) < 0.3
        scene.isolated[:] = rng.random((rows, 2)) < 0.5
        active = ~planned | (step >= tracks.start_step)
        chosen = np.flatnonzero(active) if order is None else order[active[order]]
        names = ("statistic", "scored", "alarm", "estimate_m", "isolated")
        self.history.append(
            {name: getattr(scene, name).copy() for name in names}
            | {"settled": tracks.settled.copy(), "attacked": tracks.attacked.copy(), "active": active}
            | {"error": scene.estimate_m - vehicles.rear_m[:, None], "yaw": vehicles.lane_yaw_rad.copy()}
        )
        scene.observe(step, chosen, threads)


def tails(record):
    """Steps in which an alarm of an attack goes on behind it."""
    attacked, alarm = record["attacked"][..., None], record["alarm"]
    found = np.zeros_like(alarm)
    for step in range(1, len(alarm)):
        found[step] = alarm[step] & ~attacked[step] & (found[step - 1] | (attacked[step - 1] & alarm[step - 1]))
    return found


def test_sums_equal_those_of_the_whole_record():
    world = Randomised()
    for step in range(world.STEPS):
        world.step(step)
    state, tracks = world.scene.state, world.scene.tracks
    record = {name: np.stack([entry[name] for entry in world.history]) for name in world.history[0]}
    settled, attacked = record["settled"] & record["active"], record["attacked"]
    scored = record["scored"] & (settled | attacked)[..., None] & ~tails(record)
    alarm, hit = record["alarm"], attacked[..., None]
    for i, cell in enumerate([alarm & hit, alarm & ~hit, ~alarm & hit, ~alarm & ~hit]):
        np.testing.assert_array_equal(state.counts[..., i], (scored & cell).sum(axis=0))
    np.testing.assert_array_equal(state.steps, np.stack([settled.sum(axis=0), attacked.sum(axis=0)], axis=1))

    error, yaw = record["error"], record["yaw"][..., None]
    turned = (error[..., 0] + 1j * error[..., 1]) * np.exp(-1j * yaw)
    parts = np.stack([error[..., 0], error[..., 1], turned.imag, turned.real], axis=-1)
    for when, mask in ((LIFE, settled), (ATTACK, attacked)):
        expected = np.where(mask[..., None, None], parts**2, 0.0).sum(axis=0)
        np.testing.assert_allclose(state.squared_m2[:, :, when], expected, rtol=1e-9)
        expected = np.where(mask[..., None], np.abs(turned.imag), 0.0).max(axis=0)
        np.testing.assert_allclose(state.max_cross_m[:, :, when], expected, rtol=1e-9)
    for when, mask in ((LIFE, settled), (ATTACK, attacked)):
        expected = (record["isolated"] & mask[..., None]).sum(axis=0)
        np.testing.assert_array_equal(state.isolated_steps[..., when], expected)

    def first(flags):
        return np.where(flags.any(axis=0), flags.argmax(axis=0), -1)

    np.testing.assert_array_equal(state.detection_step, first(alarm & hit))
    over = (tracks.plan == 1) & (np.arange(world.STEPS)[:, None] >= world.end)
    np.testing.assert_array_equal(state.retrust_step, first(over[..., None] & ~record["isolated"]))
    counted = np.where(tracks.plan == 1, record["active"], settled)[..., None]
    aside, width = turned.imag, world.scene.vehicles.width_m[:, None]
    beyond = 1.6 + width / 2 + np.where(aside < 0, 3.2, 0.0)
    classes = [np.abs(aside) > (3.2 - width) / 2, np.abs(aside) > 1.6, np.abs(aside) > beyond]
    classes.append(np.abs(aside) > beyond + 3.2)
    for i, reached in enumerate(classes):
        np.testing.assert_array_equal(state.first_step[..., i], first(counted & reached))
    assert (state.first_step >= 0).any(axis=(0, 1)).all()  # every class has happened


def test_histograms_hold_every_scored_sample_of_both_classes():
    world = Randomised()
    for step in range(world.STEPS):
        world.step(step)
    counts = world.scene.state.counts
    for plan in (0, 1):
        mine = counts[world.scene.tracks.plan == plan].sum(axis=0)
        found = world.scene.outcomes.histogram[plan, 0].sum(axis=-1)
        np.testing.assert_array_equal(found[:, 1], mine[:, 0] + mine[:, 2])
        record = {name: np.stack([entry[name] for entry in world.history]) for name in world.history[0]}
        tail = (tails(record) & record["scored"])[:, world.scene.tracks.plan == plan].sum(axis=(0, 1))
        np.testing.assert_array_equal(found[:, 0], mine[:, 1] + mine[:, 3] + tail)
    assert not world.scene.outcomes.histogram[:, 1].any()


def test_bits_depend_neither_on_threads_nor_on_the_order_of_rows():
    plain, threaded = Randomised(rows=1100), Randomised(rows=1100)
    threads = Threads(2)
    order = np.random.default_rng(0).permutation(1100).astype(np.int32)
    for step in range(0, 80, 4):
        plain.step(step)
        threaded.step(step, order, threads)
    threads.close()
    for name in OutcomeState._fields:
        assert getattr(plain.scene.state, name).tobytes() == getattr(threaded.scene.state, name).tobytes(), name
    np.testing.assert_array_equal(plain.scene.outcomes.histogram, threaded.scene.outcomes.histogram)


def test_a_row_that_is_reset_remembers_nothing():
    world = Randomised()
    for step in range(60):
        world.step(step)
    table = world.scene.outcomes.table
    table.reset(np.arange(world.rows, dtype=np.int32))
    table.grow(world.rows + 3)
    blank = Table(OutcomeState, world.rows + 3, detectors=2, defences=2).now
    for name in OutcomeState._fields:
        np.testing.assert_array_equal(getattr(table.now, name), getattr(blank, name))
    assert Table(Tracks, 1).now.plan[0] == 0


def test_a_lane_that_leads_the_other_way_is_left_out_of_everything():
    scene = Scene()
    play(scene, 0, "--")
    scene.fork(0, 1, plan=1, step=2)
    play(scene, 1, "--", first_step=2)
    scene.vehicles.against[0] = True
    scene.estimate_m[1] = 9.0, -9.0
    play(scene, 1, "AAA", first_step=4)
    assert scene.state.detection_step[1, 0] == -1
    scene.vehicles.against[0] = False
    scene.estimate_m[1] = 0.0, 0.3
    play(scene, 1, "-A-", first_step=7)
    state = scene.state
    np.testing.assert_array_equal(state.steps[1], [2 + 2 + 3, 2 + 3])
    np.testing.assert_array_equal(state.counts[1, 0], [1, 0, 4, 2])
    np.testing.assert_array_equal(state.onsets[1, 0], [1, 0])
    assert state.detection_step[1, 0] == 8
    assert state.max_cross_m[1, 0, ATTACK] == pytest.approx(0.3)
    assert (state.first_step[1] == -1).all()
    # The vehicle leaves while attacked: the attack has lasted for all of its steps.
    scene.close(1, "v")
    np.testing.assert_array_equal(scene.outcomes.tracks().last_step(), [2 + 2 + 3 + 3])


def test_an_attack_that_begins_on_the_oncoming_lane_counts_from_where_it_is_left():
    scene = Scene()
    scene.estimate_m[0] = 0.0, 5.0
    play(scene, 0, "-A")  # off the road already without an attack
    scene.fork(0, 1, plan=1, step=2)
    scene.vehicles.against[0] = True
    play(scene, 1, "AA", first_step=2)
    scene.vehicles.against[0] = False
    scene.estimate_m[1] = 0.0, 0.0
    play(scene, 1, "A", first_step=4)
    assert scene.state.in_alarm_at_start[1, 0]
    assert scene.state.detection_step[1, 0] == 4
    assert (scene.state.first_step[1, 0] == -1).all()
