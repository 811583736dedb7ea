"""Lengths of the lanes of a net, against their shapes.

SUMO counts positions along a lane's length, of which the lanes of one edge need the same, and maps them onto its shape.
"""

from xml.etree.ElementTree import Element

import numpy as np

from gpsec.core.errors import shown
from gpsec.opendrive.netfile import NetLane, by_edge
from gpsec.opendrive.polylines import stations

_SHORTEST_M = 0.1
# A lane is said to differ where its shape and its length differ by more than both.
DIFFERS_SHARE, _DIFFERS_M = 0.1, 1.0


def agree_lengths(root: Element, lanes: list[NetLane]) -> None:
    """Give the lanes of every edge the mean length of their shapes."""
    elements = {edge.get("id", ""): list(edge.iterfind("lane")) for edge in root.iterfind("edge")}
    for edge, indices in by_edge(lanes).items():
        mean = np.mean([_drawn(lanes[index]) for index in indices])
        for lane in elements[edge]:
            lane.set("length", f"{max(float(mean), _SHORTEST_M):.4f}")


def differing(lanes: list[NetLane]) -> list[str]:
    """Return the lanes whose shape and length differ by more than a tenth, with both lengths."""
    found = []
    for lane in lanes:
        drawn, length = _drawn(lane), float(lane.element.get("length", "nan"))
        if abs(drawn - length) > max(DIFFERS_SHARE * length, _DIFFERS_M):
            found.append(f"'{shown(lane.lane_id)}' ({drawn:.1f} m of shape for {length:.1f} m)")
    return found


def _drawn(lane: NetLane) -> float:
    return float(stations(lane.points_m)[-1]) if len(lane.points_m) else 0.0
