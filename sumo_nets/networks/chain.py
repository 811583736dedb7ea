"""Networks that grow from a trunk road: each piece starts where the last one ended, side roads leave at junctions."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sumo_nets.alignment import Pose, drive
from sumo_nets.plan import Lanes, Plan

Steps = Sequence[float | tuple[float, float]]

SETBACK_M = 14.0
"""Distance from the middle of a junction to where its roads begin."""


def trunk(
    plan: Plan,
    start: Pose,
    pieces: Sequence[Steps],
    side_roads: Sequence[tuple[float, Steps]],
    *,
    lanes: Sequence[Lanes | Sequence[tuple[float, Lanes]]],
    speed_kmh: float,
    width_m: float,
) -> None:
    """Lay a trunk of several pieces; between two pieces a side road leaves at an angle (degrees, left positive)."""
    pose, before = start, None
    for index, steps in enumerate(pieces):
        alignment = drive(pose, steps)
        last = index == len(pieces) - 1
        after = None if last else plan.junction(f"fork {index + 1}", "priority")
        plan.street(
            f"trunk {index + 1}",
            alignment,
            lanes=lanes[index],
            speed_kmh=speed_kmh,
            width_m=width_m,
            rank=2,
            start=before,
            end=after,
        )
        if after is None:
            return
        angle, side_steps = side_roads[index]
        x, y, heading = alignment.end
        middle = (x + SETBACK_M * math.cos(heading), y + SETBACK_M * math.sin(heading))
        plan.street(
            f"side road {index + 1}",
            drive(_leave(middle, heading + math.radians(angle)), side_steps),
            lanes=(1, 1),
            speed_kmh=speed_kmh,
            width_m=width_m,
            rank=1,
            start=after,
        )
        pose, before = _leave(middle, heading), after


def _leave(middle: tuple[float, float], heading: float) -> Pose:
    """Pose of a road that leaves a junction's middle."""
    return middle[0] + SETBACK_M * math.cos(heading), middle[1] + SETBACK_M * math.sin(heading), heading
