"""What is remembered of every track: running sums, so that memory does not grow with the steps."""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import blank

# Last axis of `counts`.
TP, FP, FN, TN = 0, 1, 2, 3
# Last axis of `onsets`.
ALL, FALSE = 0, 1
# Over what errors are summed: the settled life of the vehicle, or the steps under attack.
LIFE, ATTACK = 0, 1
# Components of the error of an estimate.
X, Y, CROSS, ALONG = 0, 1, 2, 3
# What the error would have meant, in the order of severity; the last axis of `first_step`.
LINE_TOUCHED, OUT_OF_LANE, WRONG_WAY, OFF_ROAD = 0, 1, 2, 3
OUTCOMES = ("line_touched", "out_of_lane", "wrong_way", "off_road")
# Columns of the largest errors of an event, and of their means over events: the paper's "average maximum".
LARGEST = ("max_x_m", "max_y_m", "max_xy_m")
AVERAGE_MAX = tuple(f"average_{name}" for name in LARGEST)


class OutcomeState(NamedTuple):
    """Running sums of M track rows with K detectors and D defences.

    A track under an attack plan is forked by copying the row of the benign track, so that what was counted before
    the attack is kept. A step is *scored* by a detector whose statistic is defined in it. The *tail* of an alarm is
    what is left of it when the attack is over: no false alarm, but no true one either.

    Attributes:
        in_event: (M,) the track is under an attack plan and its attack has begun.
        steps: (M, 2) number of steps, of the settled life and under attack.
        left_out: (M,) number of further steps under attack, in which nothing is scored: the lane leads the other way.
        counts: (M, K, 4) scored steps that are TP, FP, FN, TN: positive while attacked, negative otherwise; those of a
            tail are none of them.
        onsets: (M, K, 2) alarms that were raised: all, and those raised while not attacked.
        in_alarm: (M, K) in alarm after the last step (of the settled life).
        in_alarm_at_start: (M, K) was in alarm already when the attack began.
        detection_step: (M, K) first step under attack that is in alarm, -1 where there is none.
        bin: (M, K) histogram bin of the statistic of the last step, -1 where it is not counted.
        last_bin: (M, K) that of the last scored step, 0 where an alarm would have ended since; of benign tracks.
        peak: (M, K) largest statistic under attack.
        in_tail: (M, K) the alarm of the attack that is over has not ended.
        tail_end_step: (M, K) first step after the attack without alarm, where there was one in its last step, else -1.
        squared_m2: (M, D, 2, 4) sums of squared errors x, y, cross-track, along-track; over life and attack.
        max_cross_m: (M, D, 2) largest absolute cross-track error; over life and attack.
        largest_m: (M, D, 3) largest error under attack: absolute in x, in y, and of the distance.
        first_step: (M, D, 4) first step of each outcome since the attack began (plan 0: since settling), or -1.
        deviation_m: (M, D) absolute cross-track error in the step of detection by the defence's detector.
        undetected_m: (M, K) largest absolute cross-track error of the undefended estimate, defence 0, under attack and
            before `detection_step`.
        undetected_step: (M, K) step of that error, -1 before there is one.
        isolated_steps: (M, D, 2) number of steps in which GNSS was not used, of the settled life and under attack.
        retrust_step: (M, D) first step after the attack in which GNSS is used, -1 before.
        start_m, start_lane, start_mps: (M, 2), (M,), (M,) where the attack began, on which lane, at which speed.
        detected_m, detected_lane, detected_mps: (M, K, …) the same in `detection_step`.
        left_lane_m, departed_lane, departed_mps: (M, D, …) the same in the first step out of the lane.
        last_edge: (M,) edge in the last step that was counted, else -1.
        twin: (M,) row of the same vehicle without an attack.
        twin_in_alarm: (M, K) whether that was in alarm in some step in which this one was attacked.
        twin_first_step: (M, D, 4) as `first_step`, of the twin in the same steps.
        twin_squared_m2: (M, D, 4) as `squared_m2` under attack, of the twin in the same steps.
        camera_lane: (M,) lane that the camera showed in the last step, -1 before the first.
        changed_steps: (M,) steps since that went over to the lane beside, -1 where it never did.
        right_soon: (M,) the lane that was believed soon after that was the right one.

    """

    in_event: Flags = blank(False)
    steps: Ints = blank(0, 2)
    left_out: Ints = blank(0)
    counts: Ints = blank(0, "detectors", 4)
    onsets: Ints = blank(0, "detectors", 2)
    in_alarm: Flags = blank(False, "detectors")
    in_alarm_at_start: Flags = blank(False, "detectors")
    detection_step: Ints = blank(-1, "detectors")
    bin: Ints = blank(-1, "detectors")
    last_bin: Ints = blank(0, "detectors")
    peak: Floats = blank(0.0, "detectors")
    in_tail: Flags = blank(False, "detectors")
    tail_end_step: Ints = blank(-1, "detectors")
    squared_m2: Floats = blank(0.0, "defences", 2, 4)
    max_cross_m: Floats = blank(0.0, "defences", 2)
    largest_m: Floats = blank(0.0, "defences", 3)
    first_step: Ints = blank(-1, "defences", 4)
    deviation_m: Floats = blank(0.0, "defences")
    undetected_m: Floats = blank(0.0, "detectors")
    undetected_step: Ints = blank(-1, "detectors")
    isolated_steps: Ints = blank(0, "defences", 2)
    retrust_step: Ints = blank(-1, "defences")
    start_m: Floats = blank(0.0, 2)
    start_lane: Ints = blank(-1)
    start_mps: Floats = blank(0.0)
    detected_m: Floats = blank(0.0, "detectors", 2)
    detected_lane: Ints = blank(-1, "detectors")
    detected_mps: Floats = blank(0.0, "detectors")
    left_lane_m: Floats = blank(0.0, "defences", 2)
    departed_lane: Ints = blank(-1, "defences")
    departed_mps: Floats = blank(0.0, "defences")
    last_edge: Ints = blank(-1)
    twin: Ints = blank(-1)
    twin_in_alarm: Flags = blank(False, "detectors")
    twin_first_step: Ints = blank(-1, "defences", 4)
    twin_squared_m2: Floats = blank(0.0, "defences", 4)
    camera_lane: Ints = blank(-1)
    changed_steps: Ints = blank(-1)
    right_soon: Flags = blank(False)


def worst(first_step: Ints) -> tuple[Ints, Ints]:
    """Return the (…,) worst outcome reached, -1 for none, and its first step, of (…, 4) first steps.

    Of wrong way and off road, the one that came first counts; of both in one step, off road.
    """
    wrong, off = first_step[..., WRONG_WAY], first_step[..., OFF_ROAD]
    outcome = np.full(first_step.shape[:-1], -1, np.int32)
    outcome[first_step[..., LINE_TOUCHED] >= 0] = LINE_TOUCHED
    outcome[first_step[..., OUT_OF_LANE] >= 0] = OUT_OF_LANE
    outcome[wrong >= 0] = WRONG_WAY
    outcome[(off >= 0) & ((wrong < 0) | (off <= wrong))] = OFF_ROAD
    step = np.take_along_axis(first_step, np.maximum(outcome, 0)[..., None], axis=-1)[..., 0]
    return outcome, np.where(outcome >= 0, step, -1).astype(np.int32)
