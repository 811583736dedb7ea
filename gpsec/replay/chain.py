"""A net of one chain of lanes, along which a log's vehicle drove: what stands for the map where a log has none."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.replay.grid import LOG_STEP_S, SteppedDrive
from gpsec.replay.log import NO_PROJECTION

LANE_WIDTH_M = 3.5
# Points of the centre line; what is smoothed over, of the pose and of the camera's lane; length of an edge.
_SPACING_M, _SMOOTH_M, _SMOOTH_LANE_M, _EDGE_M = 2.0, 14.0, 50.0, 250.0
# Straight on before the first and behind the last position, where no fix may lead off the map.
_BEYOND_M = 60.0
# A lane change: C0 goes over to another line. For so long the camera is taken to show no lane.
JUMP_M, _BLIND_S = 1.5, 3.0


@dataclass(frozen=True)
class LaneChain:
    """Lanes one behind the other.

    Attributes:
        points_m: (n, 2) of the centre line.
        first: (E + 1,) where in `points_m` each edge begins, and where the last one ends.
        edge: (S,) edge that the front of the vehicle is on, by step.
        blind: (S,) steps about a lane change, in which the camera shows another lane than the chain.
        changes: number of lane changes.
    """

    points_m: Floats
    first: Ints
    edge: Ints
    blind: Flags
    changes: int


def lane_id(edge: int) -> str:
    """Return the id of the lane of an edge."""
    return f"way{edge}_0"


def make_chain(drive: SteppedDrive, axle_m: float) -> LaneChain:
    """Return the chain of a drive: through its positions, or where its camera saw the middle of the lane.

    `axle_m` is the distance from the front back to the rear axle.
    """
    way_m = np.maximum.accumulate(np.concatenate([[0.0], np.cumsum(np.maximum(drive.speed_mps[1:], 0.0) * LOG_STEP_S)]))
    middle_m, blind, changes = _middle(drive)
    at_m = np.arange(0.0, way_m[-1] + 0.5 * _SPACING_M, _SPACING_M)
    new = np.concatenate([[True], np.diff(way_m) > 1e-6])
    line = np.column_stack([np.interp(at_m, way_m[new], axis) for axis in middle_m[new].T])
    smooth_m = _SMOOTH_LANE_M if len(drive.lane) else _SMOOTH_M
    width = min(2 * int(smooth_m / _SPACING_M / 2.0) + 1, len(line) - 1 + len(line) % 2)
    line = savgol_filter(line, width, 2, axis=0)
    ahead = int(_BEYOND_M / _SPACING_M)
    begins, ends = line[0] - line[1], line[-1] - line[-2]
    before = line[0] + begins / np.hypot(*begins) * _SPACING_M * np.arange(ahead, 0, -1)[:, None]
    behind = line[-1] + ends / np.hypot(*ends) * _SPACING_M * np.arange(1, ahead + 1)[:, None]
    points_m = np.concatenate([before, line, behind])
    count = max(int(len(points_m) * _SPACING_M / _EDGE_M), 1)
    first = np.linspace(0, len(points_m) - 1, count + 1).astype(np.int32)
    place = ahead + (way_m + axle_m) / _SPACING_M
    edge = np.clip(np.searchsorted(first, place, side="right") - 1, 0, count - 1).astype(np.int32)
    return LaneChain(points_m, first, edge, blind, changes)


def _middle(drive: SteppedDrive) -> tuple[Floats, Flags, int]:
    """Return the (S, 2) middle of the lane beside each position, where the camera is not to be trusted, and how often.

    Without a camera it is the position itself.
    """
    blind = np.zeros(len(drive), np.bool_)
    if not drive.lane_there.any():
        return drive.rear_m, blind, 0
    steps = np.flatnonzero(drive.lane_there)
    seen = drive.lane[steps, 0]
    jumps = steps[1:][np.abs(np.diff(seen)) > JUMP_M]
    reach = int(_BLIND_S / LOG_STEP_S)
    for step in jumps:
        blind[max(step - reach, 0) : step + reach] = True
    c0 = np.interp(np.arange(len(drive)), steps, seen)
    left = np.column_stack([-np.sin(drive.yaw_rad), np.cos(drive.yaw_rad)])
    return drive.rear_m + c0[:, None] * left, blind, len(jumps)


def write_chain(chain: LaneChain, projection: str, path: Path) -> None:
    """Write the chain as a SUMO net, the same bytes for the same chain."""
    low, high = chain.points_m.min(axis=0), chain.points_m.max(axis=0)
    bounds = ",".join(f"{value:.2f}" for value in (*low, *high))
    place = "!" if projection == NO_PROJECTION else projection
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<net version="1.20">',
        f'<location netOffset="0.00,0.00" convBoundary="{bounds}" origBoundary="{bounds}" projParameter="{place}"/>',
    ]
    edges = len(chain.first) - 1
    for number in range(edges):
        shape = chain.points_m[chain.first[number] : chain.first[number + 1] + 1]
        length_m = np.hypot(*np.diff(shape, axis=0).T).sum()
        drawn = " ".join(f"{x:.4f},{y:.4f}" for x, y in shape)
        lines.append(
            f'<edge id="way{number}" from="n{number}" to="n{number + 1}" priority="-1">'
            f'<lane id="{lane_id(number)}" index="0" speed="55.55" length="{length_m:.4f}" width="{LANE_WIDTH_M}"'
            f' shape="{drawn}"/></edge>'
        )
    for number in range(edges + 1):
        x, y = chain.points_m[chain.first[number]]
        into = lane_id(number - 1) if number > 0 else ""
        kind = "priority" if 0 < number < edges else "dead_end"
        lines.append(
            f'<junction id="n{number}" type="{kind}" x="{x:.4f}" y="{y:.4f}" incLanes="{into}" intLanes="" shape=""/>'
        )
    for number in range(edges - 1):
        lines.append(f'<connection from="way{number}" to="way{number + 1}" fromLane="0" toLane="0" dir="s" state="M"/>')
    path.write_text("\n".join([*lines, "</net>", ""]), encoding="utf-8")
