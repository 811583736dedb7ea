"""A SUMO net: the file, and its lanes, with the OpenDRIVE lane that each was made from."""

from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError

NET_SUFFIX = ".net.xml"
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


def by_edge(lanes: list[NetLane]) -> dict[str, list[int]]:
    """Return the indices of the lanes of each edge."""
    edges: dict[str, list[int]] = {}
    for index, lane in enumerate(lanes):
        edges.setdefault(lane.lane_id.rpartition("_")[0], []).append(index)
    return edges


def points(shape: str) -> Floats:
    """Return the (n, 2) points of a shape as SUMO writes it, with or without heights."""
    return np.array([[float(value) for value in corner.split(",")[:2]] for corner in shape.split()]).reshape(-1, 2)


def import_files(net_file: Path, suffixes: tuple[str, ...], overwrite: bool) -> list[Path]:
    """Return the files that an import writes: the net's name with each suffix instead of its own.

    Raises:
        GpsecError: they cannot be written there, or exist and may not be replaced.
    """
    if not net_file.name.endswith(NET_SUFFIX) or net_file.name == NET_SUFFIX:
        raise GpsecError(f"{net_file}: expected a name that ends in {NET_SUFFIX} for the net")
    if not net_file.parent.is_dir():
        raise GpsecError(f"{net_file}: cannot be written, there is no folder {net_file.parent}")
    files = [net_file.with_name(net_file.name.removesuffix(NET_SUFFIX) + suffix) for suffix in suffixes]
    for path in files:
        if path.is_dir():
            raise GpsecError(f"{path}: cannot be written, it is a folder")
        if path.exists() and not overwrite:
            raise GpsecError(f"{path}: exists; give --overwrite to replace it, or choose another --out")
    return files
