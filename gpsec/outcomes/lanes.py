"""Whether tracks believe to be on the lane that their camera shows: counts, and the table `association.csv`."""

from math import cos, sin
from typing import NamedTuple

import numpy as np
import pandas as pd

from gpsec.core.arrays import Flags, Floats, Ints, Longs
from gpsec.core.kernels import inline, kernel
from gpsec.hdmap.arrays import Roads
from gpsec.hdmap.search import Ray, match_tracked, project
from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.study import Study
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# A believed lane is right if the true rear axle is as far from it as from the camera's lane, to within this.
RIGHT_M = 0.5
# How long after a lane change it is looked at.
SOON_S, LATER_S = 0.1, 0.5
# Phases of a track: without an attack, under one, and afterwards.
PHASES = ("honest", "attacked", "after")
HONEST, DURING, AFTER = range(3)
# What is counted: steps at each place and the right ones of these; lane changes, and the right ones soon, and later.
JUDGED_PLACES = ("road", "seen", "junction", "fork")
JUDGED, UNKNOWN_LANE, UNMATCHED_STEPS, CHANGES, SOON, LATER, FIRST_PLACE = range(7)
COUNTED = FIRST_PLACE + 2 * len(JUDGED_PLACES)


class Judge(NamedTuple):
    """What lanes are judged by.

    Attributes:
        roads: the true map.
        forked: (L,) the lane is one of several that a lane leads to.
        soon_steps, later_steps: how long after a lane change it is looked at.
    """

    roads: Roads
    forked: Flags
    soon_steps: int
    later_steps: int

    @classmethod
    def on(cls, roads: Roads, step_s: float) -> "Judge":
        """Return the judge of a map at a step length."""
        return cls(roads, forked_lanes(roads), round(SOON_S / step_s), round(LATER_S / step_s))


def forked_lanes(roads: Roads) -> Flags:
    """Return (L,) whether a lane is one of several that a lane leads to."""
    graph = roads.graph
    found = np.zeros(len(graph.after_first), np.bool_)
    for first, count in zip(graph.after_first.tolist(), graph.after_count.tolist(), strict=True):
        if count > 1:
            found[graph.after_lane[first : first + count]] = True
    return found


def no_counts(plans: int, profiles: int) -> Longs:
    """Return (P, profiles, 3, COUNTED) zeros."""
    return np.zeros((plans, profiles, len(PHASES), COUNTED), np.int64)


@inline
def is_right(roads: Roads, lane: int, v: int, vehicles: Vehicles) -> bool:
    """Return whether a lane is as good as the one that the camera of a vehicle shows."""
    if lane < 0:
        return False
    if lane == vehicles.camera_lane[v]:
        return True
    lanes = roads.lanes
    x, y, yaw = vehicles.rear_m[v, 0], vehicles.rear_m[v, 1], vehicles.yaw_rad[v]
    segment = match_tracked(lanes, roads.lookup, 0, lane, True, Ray(x, y, cos(yaw), sin(yaw)), -1)
    if segment < 0:
        return False
    _, d2 = project(lanes, segment, x, y, True)
    cross = lanes.dx[segment] * (y - lanes.y0_m[segment]) - lanes.dy[segment] * (x - lanes.x0_m[segment])
    offset = d2**0.5 if cross >= 0.0 else -(d2**0.5)
    return bool(abs(offset - vehicles.camera_offset_m[v]) < RIGHT_M)


@kernel
def judge_lanes(
    rows: Ints,
    judge: Judge,
    tracks: Tracks,
    vehicles: Vehicles,
    seen: Measurements,
    sums: OutcomeState,
    counts: Longs,
) -> None:
    """Count the steps of settled or attacked tracks, where their vehicle is on its own side of the road.

    `counts` are those of `no_counts`. Several rows share a cell, so this is not for more than one thread.
    """
    roads = judge.roads
    internal = roads.sides.internal
    for row in rows:
        v = tracks.vehicle[row]
        right = is_right(roads, tracks.lane[row], v, vehicles)
        _follow_change(row, right, judge, vehicles.camera_lane[v], sums)
        if vehicles.against[v] or not (tracks.settled[row] or tracks.attacked[row]):
            continue
        phase = DURING if tracks.attacked[row] else (HONEST if tracks.plan[row] == 0 else AFTER)
        cell = counts[tracks.plan[row], vehicles.profile[v], phase]
        here = roads.lanes.lane[vehicles.segment[v]]
        inside = internal[vehicles.lane[v]] or internal[here]
        cell[JUDGED] += 1
        cell[UNKNOWN_LANE] += not tracks.lane_known[row]
        cell[UNMATCHED_STEPS] += tracks.unmatched[row]
        for place, there in enumerate((not inside, seen.camera_valid[v], inside, judge.forked[here])):
            if there:
                cell[FIRST_PLACE + 2 * place] += 1
                cell[FIRST_PLACE + 2 * place + 1] += right
        if sums.changed_steps[row] == judge.later_steps:
            cell[CHANGES] += 1
            cell[SOON] += sums.right_soon[row]
            cell[LATER] += right


@inline
def _follow_change(row: int, right: bool, judge: Judge, lane: int, sums: OutcomeState) -> None:
    """Note how long ago the camera went over to the lane beside, and whether the track was right soon after."""
    before, graph = sums.camera_lane[row], judge.roads.graph
    if before >= 0 and lane != before and (graph.left[before] == lane or graph.right[before] == lane):
        sums.changed_steps[row] = 0
    elif sums.changed_steps[row] >= 0:
        sums.changed_steps[row] += 1
    if sums.changed_steps[row] == judge.soon_steps:
        sums.right_soon[row] = right
    sums.camera_lane[row] = lane


def association_table(study: Study, counts: Longs, scenario: str) -> pd.DataFrame:
    """Return a row for each profile, plan and phase in which there were steps; shares are empty where nothing was."""
    found = [
        (plan, profile, phase)
        for plan in range(len(study.plans))
        for profile in range(len(study.profiles))
        for phase in range(len(PHASES))
        if counts[plan, profile, phase, JUDGED] > 0
    ]
    cells = np.array([counts[at] for at in found], np.int64).reshape(-1, COUNTED)
    table = {
        "scenario": np.full(len(found), scenario, object),
        "profile": np.array([study.profiles[profile] for _, profile, _ in found], object),
        "attack": np.array([study.plans[plan] for plan, _, _ in found], object),
        "phase": np.array([PHASES[phase] for _, _, phase in found], object),
        "association": np.full(len(found), study.association, object),
        "steps": cells[:, JUDGED],
        "unknown_share": _share(cells[:, UNKNOWN_LANE], cells[:, JUDGED]),
        "unmatched_share": _share(cells[:, UNMATCHED_STEPS], cells[:, JUDGED]),
    }
    for place, name in enumerate(JUDGED_PLACES):
        of = cells[:, FIRST_PLACE + 2 * place]
        table |= {f"{name}_steps": of, f"{name}_right_share": _share(cells[:, FIRST_PLACE + 2 * place + 1], of)}
    changes = cells[:, CHANGES]
    table |= {
        "lane_changes": changes,
        "right_within_100_ms_share": _share(cells[:, SOON], changes),
        "right_within_500_ms_share": _share(cells[:, LATER], changes),
    }
    return pd.DataFrame(table)


def honest_shares(study: Study, counts: Longs) -> dict[str, float]:
    """Return the share of honest steps on roads on the right lane, for each profile that had any."""
    honest = counts[0, :, HONEST, FIRST_PLACE : FIRST_PLACE + 2].tolist()
    return {name: right / steps for name, (steps, right) in zip(study.profiles, honest, strict=True) if steps > 0}


def _share(part: Longs, whole: Longs) -> Floats:
    return np.where(whole > 0, part / np.maximum(whole, 1), np.nan)
