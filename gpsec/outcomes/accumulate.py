"""The kernel that adds one step to the running sums. Every row is independent of the others."""

from math import cos, sin, sqrt

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.histograms import bin_of
from gpsec.outcomes.places import note_places
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
    OutcomeState,
    X,
    Y,
)
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles


@kernel
def add_step(
    rows: Ints,
    step: int,
    tracks: Tracks,
    vehicles: Vehicles,
    answers: Answers,
    sums: OutcomeState,
    sides: LaneSides,
    detector: Ints,
) -> None:
    """Add one step of the track rows `rows` to the sums; `detector` (D,) is the one that each defence listens to.

    A track on a lane that leads the other way is left out: it has no lane of its own to be displaced in.
    """
    for row in rows:
        if vehicles.against[tracks.vehicle[row]]:
            sums.left_out[row] += tracks.attacked[row]
            sums.bin[row, :] = -1
        else:
            _add_alarms(row, step, tracks, answers, sums)
            _add_errors(row, step, tracks, vehicles, answers, sums, sides, detector)
            _add_twin(row, step, tracks, vehicles, answers, sums, sides)
        note_places(row, step, tracks, vehicles, sums)


@inline
def _add_alarms(row: int, step: int, tracks: Tracks, answers: Answers, sums: OutcomeState) -> None:
    """Add what the detectors say of a track; run it before `_add_errors`, which marks the event as begun."""
    hit = tracks.attacked[row]
    counted = tracks.settled[row] or hit
    begins = tracks.plan[row] > 0 and not sums.in_event[row]
    counts, onsets = sums.counts[row], sums.onsets[row]
    for k in range(answers.alarm.shape[1]):
        called = answers.alarm[row, k]
        if begins:
            sums.in_alarm_at_start[row, k] = sums.in_alarm[row, k]
        if not counted:
            sums.in_alarm[row, k] = False
            sums.bin[row, k] = -1
            continue
        _follow_tail(row, k, step, hit, called, sums)
        if answers.scored[row, k]:
            if hit:
                counts[k, TP if called else FN] += 1
                sums.peak[row, k] = max(sums.peak[row, k], answers.statistic[row, k])
            elif not sums.in_tail[row, k]:
                counts[k, FP if called else TN] += 1
            sums.bin[row, k] = bin_of(answers.statistic[row, k])
        else:
            sums.bin[row, k] = -1
        if called and not sums.in_alarm[row, k]:
            onsets[k, ALL] += 1
            if not hit:
                onsets[k, FALSE] += 1
        if called and hit and sums.detection_step[row, k] < 0:
            sums.detection_step[row, k] = step
        sums.in_alarm[row, k] = called


@inline
def _follow_tail(row: int, k: int, step: int, hit: bool, called: bool, sums: OutcomeState) -> None:
    """Note whether the alarm of an attack goes on behind it, and when it ends."""
    if hit:
        sums.in_tail[row, k] = called
    elif sums.in_tail[row, k] and not called:
        sums.in_tail[row, k] = False
        sums.tail_end_step[row, k] = step


@inline
def _add_errors(
    row: int,
    step: int,
    tracks: Tracks,
    vehicles: Vehicles,
    answers: Answers,
    sums: OutcomeState,
    sides: LaneSides,
    detector: Ints,
) -> None:
    """Add the errors of the D estimates of a track.

    The error is estimate − truth; cross-track and along-track are its parts across (left positive) and along the
    true direction of the lane.
    """
    v = tracks.vehicle[row]
    hit, scoring = tracks.attacked[row], tracks.settled[row]
    planned = tracks.plan[row] > 0
    if planned and not sums.in_event[row]:
        sums.in_event[row] = True
        sums.first_step[row] = -1  # what the benign track did before the fork is no outcome of the attack
    if scoring:
        sums.steps[row, LIFE] += 1
    if hit:
        sums.steps[row, ATTACK] += 1
    over = planned and tracks.end_step[row] >= 0 and step >= tracks.end_step[row]
    lane = vehicles.lane[v]
    c, s = cos(vehicles.lane_yaw_rad[v]), sin(vehicles.lane_yaw_rad[v])
    for d in range(answers.estimate_m.shape[1]):
        x = answers.estimate_m[row, d, 0] - vehicles.rear_m[v, 0]
        y = answers.estimate_m[row, d, 1] - vehicles.rear_m[v, 1]
        isolated = answers.isolated[row, d]
        cross, along = c * y - s * x, c * x + s * y
        if scoring:
            _add(sums.squared_m2[row, d, LIFE], x, y, cross, along)
            sums.max_cross_m[row, d, LIFE] = max(sums.max_cross_m[row, d, LIFE], abs(cross))
            sums.isolated_steps[row, d, LIFE] += isolated
        if hit:
            _add(sums.squared_m2[row, d, ATTACK], x, y, cross, along)
            sums.max_cross_m[row, d, ATTACK] = max(sums.max_cross_m[row, d, ATTACK], abs(cross))
            largest = sums.largest_m[row, d]
            largest[0], largest[1] = max(largest[0], abs(x)), max(largest[1], abs(y))
            largest[2] = max(largest[2], sqrt(x * x + y * y))
            sums.isolated_steps[row, d, ATTACK] += isolated
            if d == 0:
                _note_undetected(row, step, abs(cross), sums)
        if sums.detection_step[row, detector[d]] == step:
            sums.deviation_m[row, d] = abs(cross)
        if over and sums.retrust_step[row, d] < 0 and not isolated:
            sums.retrust_step[row, d] = step
        if (planned or scoring) and lane >= 0 and not sides.internal[lane]:
            _note_outcomes(sums.first_step[row, d], step, cross, vehicles.width_m[v], lane, sides)


@inline
def _note_undetected(row: int, step: int, deviation_m: float, sums: OutcomeState) -> None:
    """Note by how much the undefended estimate is off before each detector's first alarm."""
    for k in range(sums.undetected_m.shape[1]):
        if sums.detection_step[row, k] < 0 and deviation_m > sums.undetected_m[row, k]:
            sums.undetected_m[row, k] = deviation_m
            sums.undetected_step[row, k] = step


@inline
def _add_twin(
    row: int,
    step: int,
    tracks: Tracks,
    vehicles: Vehicles,
    answers: Answers,
    sums: OutcomeState,
    sides: LaneSides,
) -> None:
    """Add what the same vehicle has without the attack, in the steps in which a track under a plan is looked at."""
    twin = sums.twin[row]
    if twin < 0 or not sums.in_event[row]:
        return
    v, hit = tracks.vehicle[row], tracks.attacked[row]
    if hit:
        for k in range(answers.alarm.shape[1]):
            sums.twin_in_alarm[row, k] |= answers.alarm[twin, k]
    lane = vehicles.lane[v]
    c, s = cos(vehicles.lane_yaw_rad[v]), sin(vehicles.lane_yaw_rad[v])
    for d in range(answers.estimate_m.shape[1]):
        x = answers.estimate_m[twin, d, 0] - vehicles.rear_m[v, 0]
        y = answers.estimate_m[twin, d, 1] - vehicles.rear_m[v, 1]
        cross, along = c * y - s * x, c * x + s * y
        if hit:
            _add(sums.twin_squared_m2[row, d], x, y, cross, along)
        if lane >= 0 and not sides.internal[lane]:
            _note_outcomes(sums.twin_first_step[row, d], step, cross, vehicles.width_m[v], lane, sides)


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
