"""Reads a SUMO network into plain lane records."""

import xml.sax
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, retold, shown
from gpsec.core.geo import Projector

# A lane that only these may use is no lane of the HD map.
_OFF_ROAD_CLASSES = frozenset(
    [
        "pedestrian",
        "wheelchair",
        "bicycle",
        "tram",
        "rail_urban",
        "rail",
        "rail_electric",
        "rail_fast",
        "ship",
        "container",
        "cable_car",
        "subway",
        "aircraft",
        "drone",
    ]
)
_MIN_SEGMENT_M = 1e-3
# Beyond these a file is broken, and the map would fill the memory.
_MAX_COORDINATE_M, _MAX_LANE_M, _MAX_WIDTH_M = 1e8, 1e6, 100.0
# What sumolib lets through where a file is no net; lxml, which it takes where it is installed, raises a SyntaxError.
_UNREADABLE = (
    xml.sax.SAXException,
    SyntaxError,
    OSError,
    EOFError,
    zlib.error,
    ValueError,
    LookupError,
    OverflowError,
    AttributeError,
    TypeError,
)


@dataclass(frozen=True)
class Lane:
    """One lane of a net.

    Attributes:
        lane_id: SUMO's id.
        edge: number of its edge among those of the net.
        internal: inside a junction.
        width_m: of the lane.
        length_m: that SUMO counts positions along; its shape may have another.
        shape_m: (n, 2) centre line in driving order, without repeated points.
        successors: ids of the lanes that it leads to.

    """

    lane_id: str
    edge: int
    internal: bool
    width_m: float
    length_m: float
    shape_m: Floats
    successors: tuple[str, ...]


@dataclass(frozen=True)
class Net:
    """The lanes that road vehicles may use, and where on the Earth they lie.

    Attributes:
        lanes: those with an extent.
        points: lanes that are only a point -> the lane behind them; a vehicle's front may stop on one.
        projector: between the net's frame and WGS84.
    """

    lanes: list[Lane]
    points: dict[str, str]
    projector: Projector


def read_net(net_file: Path) -> Net:
    """Read a ``.net.xml`` (or ``.net.xml.gz``).

    Raises:
        GpsecError: the file is missing or broken, holds no drivable lane, or one with a speed that is not positive.

    """
    if not net_file.is_file():
        raise GpsecError(f"{net_file}: no such net file")
    import sumolib  # late: most runs find the map compiled

    try:
        net = sumolib.net.readNet(str(net_file), withInternal=True)
        lanes, points = _drivable(net, net_file)
        projector = _projector(net, net_file)
    except _UNREADABLE as error:
        raise GpsecError(
            f"{net_file}: not a SUMO net that can be read ({type(error).__name__}: {retold(str(error))})"
        ) from None
    if not any(not lane.internal for lane in lanes):
        raise GpsecError(f"{net_file}: no lane that a road vehicle may use")
    known = {lane.lane_id for lane in lanes}
    lanes = [replace(lane, successors=tuple(dict.fromkeys(_beyond(lane.successors, known, points)))) for lane in lanes]
    behind = {point: next(_beyond(after, known, points), None) for point, after in points.items()}
    return Net(lanes, {point: lane for point, lane in behind.items() if lane is not None}, projector)


def _drivable(net: Any, net_file: Path) -> tuple[list[Lane], dict[str, tuple[str, ...]]]:
    """Return the lanes that road vehicles may use, and the successors of those that are only a point."""
    lanes: list[Lane] = []
    points: dict[str, tuple[str, ...]] = {}
    for number, edge in enumerate(net.getEdges(True)):
        function = edge.getFunction() or "normal"
        if function not in {"normal", "internal", "connector"}:
            continue
        for lane in edge.getLanes():
            if not set(lane.getPermissions()) - _OFF_ROAD_CLASSES:
                continue
            if len(_distinct(lane.getShape())) > 1:
                lanes.append(_lane(lane, number, function == "internal", net_file))
            else:
                points[lane.getID()] = _successors(lane)
    return lanes, points


def _lane(lane: Any, edge: int, internal: bool, net_file: Path) -> Lane:
    shape = _distinct(lane.getShape())
    if not (np.abs(shape) < _MAX_COORDINATE_M).all() or np.hypot(*np.diff(shape, axis=0).T).sum() > _MAX_LANE_M:
        raise GpsecError(f"{net_file}: lane '{shown(lane.getID())}': expected a shape on the Earth, of at most 1000 km")
    if not 0.0 < lane.getWidth() < _MAX_WIDTH_M:
        raise GpsecError(
            f"{net_file}: lane '{shown(lane.getID())}' has a width of {lane.getWidth()} m, "
            f"expected more than 0 and less than {_MAX_WIDTH_M:g}"
        )
    if not 0.0 < lane.getSpeed() < inf:
        raise GpsecError(
            f"{net_file}: lane '{shown(lane.getID())}' has a speed of {lane.getSpeed()} m/s, expected more than 0 "
            "(an OpenDRIVE import without a valid speed limit does that)"
        )
    width_m, length_m = float(lane.getWidth()), float(lane.getLength())
    return Lane(lane.getID(), edge, internal, width_m, length_m, shape, _successors(lane))


def _successors(lane: Any) -> tuple[str, ...]:
    return tuple(
        dict.fromkeys(connection.getViaLaneID() or connection.getToLane().getID() for connection in lane.getOutgoing())
    )


def _beyond(names: tuple[str, ...], known: set[str], points: dict[str, tuple[str, ...]]) -> Iterator[str]:
    """Yield the known lanes among `names`, and those behind an internal lane that is only a point."""
    for name in names:
        if name in known:
            yield name
        elif name in points:
            others = {point: after for point, after in points.items() if point != name}
            yield from _beyond(points[name], known, others)


def _distinct(shape: Any) -> Floats:
    points = np.asarray([point[:2] for point in shape], np.float64).reshape(-1, 2)
    if not np.isfinite(points).all():
        raise ValueError("the shape of a lane is not finite")
    if len(points) < 2:
        return points
    keep = np.concatenate([[True], np.hypot(*np.diff(points, axis=0).T) > _MIN_SEGMENT_M])
    distinct: Floats = points[keep]
    return distinct


def _projector(net: Any, net_file: Path) -> Projector:
    location: dict[str, str] = net._location
    offset = location.get("netOffset", "0,0").split(",")
    projector = Projector(location.get("projParameter", "!"), (float(offset[0]), float(offset[1])), str(net_file))
    if not all(isfinite(value) for value in projector.offset_m):
        raise ValueError("the netOffset is not finite")
    projector.to_lon_lat(np.zeros(2))  # says now whether PROJ knows the projection
    return projector
