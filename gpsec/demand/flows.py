"""Traffic along each road, for nets in which no road leads to another."""

from xml.sax.saxutils import quoteattr

import numpy as np

from gpsec.hdmap.net import Lane

# A shorter road is passed in a few seconds.
SHORTEST_FLOW_M = 50.0


def length_m(lane: Lane) -> float:
    """Return the length of a lane's centre line."""
    return float(np.hypot(*np.diff(lane.shape_m, axis=0).T).sum())


def straight_flows(lanes: list[Lane], period_s: float, duration_s: float) -> tuple[str, int]:
    """Return a route file with a flow from the beginning to the end of each road, and how many there are.

    Vehicles depart every `period_s` on average on all roads together, on each in proportion to its lanes.
    """
    count: dict[str, int] = {}
    for lane in lanes:
        if length_m(lane) >= SHORTEST_FLOW_M:
            edge = lane.lane_id.rpartition("_")[0]
            count[edge] = count.get(edge, 0) + 1
    total = sum(count.values())
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<routes>"]
    for number, (edge, width) in enumerate(sorted(count.items())):
        rate = width / total / period_s
        road = quoteattr(edge)
        lines.append(
            f'    <flow id="road{number}" type="traffic" from={road} to={road} begin="0" end="{duration_s:g}" '
            f'period="exp({rate:.5f})" departLane="best" departSpeed="max" departPos="base"/>'
        )
    return "\n".join([*lines, "</routes>", ""]), len(count)
