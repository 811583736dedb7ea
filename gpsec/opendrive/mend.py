"""Mends a finished net, and describes what is left as it is."""

import itertools
from xml.etree.ElementTree import Element

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import shown
from gpsec.opendrive.netfile import NetLane, by_edge, net_lanes
from gpsec.opendrive.polylines import at_stations, stations

DEFAULT_SPEED_MPS = 50.0 / 3.6
# A van or a truck is up to 2.55 m wide, a small car 1.65 m.
NARROW_M = 2.0


def mend_net(root: Element) -> list[str]:
    """Give every lane a speed that is positive; return what was done."""
    slow = [lane for lane in root.iterfind("edge/lane") if not float(lane.get("speed", "0")) > 0.0]
    for lane in slow:
        lane.set("speed", f"{DEFAULT_SPEED_MPS:.4f}")
    return [f"lanes without a positive speed, given 50 km/h: {len(slow)}"] if slow else []


def describe_net(root: Element) -> list[str]:
    """Return sentences on narrow lanes, crossed lanes and parts that no road joins."""
    lanes = net_lanes(root)
    said = []
    narrow = [lane for lane in lanes if lane.width_m < NARROW_M]
    if narrow:
        named = min(narrow, key=lambda lane: lane.width_m)
        said.append(
            f"lanes narrower than {NARROW_M:g} m: {len(narrow)}; '{shown(named.lane_id)}' is {named.width_m:.2f} m wide"
        )
    if crossed := _crossed(lanes, left_hand=root.get("lefthand") in ("true", "1")):
        said.append(f"edges whose lanes do not lie in SUMO's order: {len(crossed)}, such as '{shown(crossed[0])}'")
    shares = _parts(root, lanes)
    if len(shares) > 1:
        said.append(
            f"parts of the net that no road joins: {len(shares)}; the largest has {shares[0]:.0%} of the lane length"
        )
    return said


def _crossed(lanes: list[NetLane], *, left_hand: bool) -> list[str]:
    """Return the edges outside junctions whose lanes are not counted from the side of the road to its centre."""
    inwards = -1.0 if left_hand else 1.0
    drawn = [lane for lane in lanes if not lane.internal and len(lane.points_m) > 1]
    found = []
    for edge, indices in by_edge(drawn).items():
        middles = [_about_middle(drawn[index]) for index in indices]
        for outer, inner in itertools.pairwise(middles):
            ahead, across = outer[2] - outer[0], inner[1] - outer[1]
            if inwards * (ahead[0] * across[1] - ahead[1] * across[0]) < 0.0:
                found.append(edge)
                break
    return found


def _about_middle(lane: NetLane) -> Floats:
    """Return (3, 2) points before, in and behind the middle of a lane."""
    return at_stations(lane.points_m, stations(lane.points_m)[-1] * np.array([0.45, 0.5, 0.55]))


def _parts(root: Element, lanes: list[NetLane]) -> list[float]:
    """Return the share of the lane length outside junctions that each connected part has, the largest first."""
    joined: dict[str, str] = {}

    def leader(node: str) -> str:
        while joined.setdefault(node, node) != node:
            joined[node] = node = joined[joined[node]]
        return node

    edges = {edge.get("id", ""): edge for edge in root.iterfind("edge")}
    for edge in root.iterfind("edge[@from]"):
        joined[leader(edge.get("from", ""))] = leader(edge.get("to", ""))
    length: dict[str, float] = {}
    for lane in lanes:
        if not lane.internal:
            part = leader(edges[lane.lane_id.rpartition("_")[0]].get("from", ""))
            length[part] = length.get(part, 0.0) + float(stations(lane.points_m)[-1])
    shares = np.sort(list(length.values()))[::-1]
    return [float(share) for share in shares / max(shares.sum(), 1e-9)]
