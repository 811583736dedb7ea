"""The lanes of a SUMO net, with the OpenDRIVE lane that each was made from."""

from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from gpsec.arrays import Floats

ORIGINAL = "origId"


@dataclass(frozen=True)
class NetLane:
    """One lane of a net.

    Attributes:
        lane_id: SUMO's id.
        original: "road_lane" of OpenDRIVE, empty where netconvert does not say.
        internal: inside a junction, or between two lane sections.
        width_m, speed_mps: of the lane.
        points_m: (n, 2) shape.
        element: what it was read from.
    """

    lane_id: str
    original: str
    internal: bool
    width_m: float
    speed_mps: float
    points_m: Floats
    element: Element


def net_lanes(root: Element) -> list[NetLane]:
    """Return the lanes of a net that cars may use."""
    lanes = []
    for edge in root.iterfind("edge"):
        function = edge.get("function", "normal")
        if function not in {"normal", "internal"}:
            continue
        lanes += [_lane(lane, function == "internal") for lane in edge.iterfind("lane") if _for_cars(lane)]
    return lanes


def _for_cars(lane: Element) -> bool:
    allowed, forbidden = lane.get("allow"), lane.get("disallow", "").split()
    if allowed is not None:
        return bool({"all", "passenger"} & set(allowed.split()))
    return not {"all", "passenger"} & set(forbidden)


def _lane(lane: Element, internal: bool) -> NetLane:
    original = next((item.get("value", "") for item in lane.iterfind("param") if item.get("key") == ORIGINAL), "")
    return NetLane(
        lane.get("id", ""),
        original,
        internal,
        float(lane.get("width", "3.2")),
        float(lane.get("speed", "nan")),
        points(lane.get("shape", "")),
        lane,
    )


def points(shape: str) -> Floats:
    """Return the (n, 2) points of a shape as SUMO writes it, with or without heights."""
    return np.array([[float(value) for value in corner.split(",")[:2]] for corner in shape.split()]).reshape(-1, 2)
