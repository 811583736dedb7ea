"""The kernels that add one step to the running sums. Every row is independent of the others."""

from math import cos, sin

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.histograms import bin_of
from gpsec.outcomes.state import (
    ALL,
    ALONG,
    ATTACK,
    CROSS,
    FALSE,
    FN,
    FP,
    LIFE,
    LINE_TOUCHED,
    OFF_ROAD,
    OUT_OF_LANE,
    TN,
    TP,
    WRONG_WAY,
    X,
    Y,
)


@kernel
def add_alarms(
    rows: Ints,
    step: int,
    plan: Ints,
    settled: Flags,
    attacked: Flags,
    statistic: Floats,
    scored: Flags,
    alarm: Flags,
    in_event: Flags,
    counts: Ints,
    onsets: Ints,
    in_alarm: Flags,
    in_alarm_at_start: Flags,
    detection_step: Ints,
    bins: Ints,
) -> None:
    """Add what (M, K) detectors said in one step; run it before `add_errors`, which marks the event as begun."""
    for row in rows:
        hit = attacked[row]
        counted = settled[row] or hit
        begins = plan[row] > 0 and not in_event[row]
        for k in range(alarm.shape[1]):
            called = alarm[row, k]
            if begins:
                in_alarm_at_start[row, k] = in_alarm[row, k]
            if not counted:
                in_alarm[row, k] = False
                bins[row, k] = -1
                continue
            if scored[row, k]:
                if hit:
                    counts[row, k, TP if called else FN] += 1
                else:
                    counts[row, k, FP if called else TN] += 1
                bins[row, k] = bin_of(statistic[row, k])
            else:
                bins[row, k] = -1
            if called and not in_alarm[row, k]:
                onsets[row, k, ALL] += 1
                if not hit:
                    onsets[row, k, FALSE] += 1
            if called and hit and detection_step[row, k] < 0:
                detection_step[row, k] = step
            in_alarm[row, k] = called


@kernel
def add_errors(
    rows: Ints,
    step: int,
    vehicle: Ints,
    plan: Ints,
    settled: Flags,
    attacked: Flags,
    end_step: Ints,
    rear_m: Floats,
    lane_yaw_rad: Floats,
    lane: Ints,
    width_m: Floats,
    sides: LaneSides,
    estimate_m: Floats,
    isolated: Flags,
    detector: Ints,
    detection_step: Ints,
    in_event: Flags,
    steps: Ints,
    squared_m2: Floats,
    max_cross_m: Floats,
    first_step: Ints,
    deviation_m: Floats,
    isolated_steps: Ints,
    retrust_step: Ints,
) -> None:
    """Add the errors of (M, D, 2) estimates in one step; `detector` (D,) is the one that each defence listens to.

    The error is estimate − truth; cross-track and along-track are its parts across (left positive) and along the
    true direction of the lane.
    """
    for row in rows:
        v = vehicle[row]
        hit, scoring = attacked[row], settled[row]
        planned = plan[row] > 0
        if planned and not in_event[row]:
            in_event[row] = True
            first_step[row] = -1  # what the benign track did before the fork is no outcome of the attack
        if scoring:
            steps[row, LIFE] += 1
        if hit:
            steps[row, ATTACK] += 1
        over = planned and end_step[row] >= 0 and step >= end_step[row]
        c, s = cos(lane_yaw_rad[v]), sin(lane_yaw_rad[v])
        for d in range(estimate_m.shape[1]):
            x = estimate_m[row, d, 0] - rear_m[v, 0]
            y = estimate_m[row, d, 1] - rear_m[v, 1]
            cross, along = c * y - s * x, c * x + s * y
            if scoring:
                _add(squared_m2[row, d, LIFE], x, y, cross, along)
                max_cross_m[row, d, LIFE] = max(max_cross_m[row, d, LIFE], abs(cross))
            if hit:
                _add(squared_m2[row, d, ATTACK], x, y, cross, along)
                max_cross_m[row, d, ATTACK] = max(max_cross_m[row, d, ATTACK], abs(cross))
                if isolated[row, d]:
                    isolated_steps[row, d] += 1
            if detection_step[row, detector[d]] == step:
                deviation_m[row, d] = abs(cross)
            if over and retrust_step[row, d] < 0 and not isolated[row, d]:
                retrust_step[row, d] = step
            if (planned or scoring) and lane[v] >= 0 and not sides.internal[lane[v]]:
                _note_outcomes(first_step[row, d], step, cross, width_m[v], lane[v], sides)


@inline
def _add(sums: Floats, x: float, y: float, cross: float, along: float) -> None:
    sums[X] += x * x
    sums[Y] += y * y
    sums[CROSS] += cross * cross
    sums[ALONG] += along * along


@inline
def _note_outcomes(first_step: Ints, step: int, cross: float, width_m: float, lane: int, sides: LaneSides) -> None:
    """Note the (4,) first steps in which a vehicle that steers by its estimate would have been displaced too far.

    It would hold its estimate in the middle of the lane and stand displaced by −cross itself: an estimate too far to
    the left puts it to the right.
    """
    if cross > 0.0:
        same, oncoming = sides.same_right_m[lane], sides.oncoming_right_m[lane]
    else:
        same, oncoming = sides.same_left_m[lane], sides.oncoming_left_m[lane]
    lane_m = sides.width_m[lane]
    displaced = abs(cross)
    beyond = 0.5 * (lane_m + width_m) + same
    if displaced > 0.5 * (lane_m - width_m):
        _first(first_step, LINE_TOUCHED, step)
    if displaced > 0.5 * lane_m:
        _first(first_step, OUT_OF_LANE, step)
    if oncoming > 0.0 and displaced > beyond:
        _first(first_step, WRONG_WAY, step)
    if displaced > beyond + oncoming:
        _first(first_step, OFF_ROAD, step)


@inline
def _first(first_step: Ints, outcome: int, step: int) -> None:
    if first_step[outcome] < 0:
        first_step[outcome] = step
