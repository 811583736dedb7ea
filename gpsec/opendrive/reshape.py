"""Gives the lanes of a net the centre lines that the OpenDRIVE map has.

netconvert gives every lane of a road section one width and stacks them up, so that lanes beside one that opens, closes
or changes its width lie beside their true place. What lies where is known exactly, so the shapes are written anew.
"""

from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.opendrive.extents import extents
from gpsec.opendrive.junctions import along_way, blended, chains, through
from gpsec.opendrive.lanes import CentreLine
from gpsec.opendrive.lengths import agree_lengths
from gpsec.opendrive.netfile import NetLane, net_lanes, points
from gpsec.opendrive.polylines import stations
from gpsec.opendrive.ways import Ways

SPACING_M = 0.5
# Half of the points are left out where the line is so straight that it stays within this without them.
_CHORD_M = 0.001
_SHORTEST_M = 0.1


@dataclass(frozen=True)
class Reshaped:
    """How many lanes have the map's centre line now, and how many outside junctions have none."""

    lanes: int
    left_alone: int


def reshape(root: Element, lines: list[CentreLine]) -> Reshaped:
    """Write the map's centre lines into the lanes of a net; `lines` have points every `SPACING_M` or less.

    Lanes outside junctions get theirs first. A path through a junction then runs from one's end to another's beginning.
    """
    lanes = net_lanes(root)
    ways = Ways([_thinned(line) for line in lines])
    placed = extents(lanes, ways)
    new = {index: extent.shape() for index, extent in placed.items()}
    own = outer = len(new)
    joined = list(chains(root, lanes))
    for chain in joined:
        start, end = _end(new, lanes, chain.before, -1), _end(new, lanes, chain.behind, 0)
        before, behind = (placed.get(-1 if index is None else index) for index in (chain.before, chain.behind))
        shapes = through(chain, lanes, before, behind, ways) or along_way(chain, lanes, start, end, ways)
        own += len(chain.lanes) if shapes else 0
        new |= shapes or blended(chain, lanes, start, end)
    for index, shape in new.items():
        _write(lanes[index], shape)
    for chain in joined:
        # From this netedit and netconvert draw the lanes inside the junction when they write the net anew.
        corners = [corner for lane in chain.lanes for corner in lanes[lane].element.get("shape", "").split()]
        chain.link.set("shape", " ".join(dict.fromkeys(corners)))
    agree_lengths(root, net_lanes(root))
    outside = sum(not lane.internal for lane in lanes)
    return Reshaped(own, outside - outer)


def _thinned(line: CentreLine) -> CentreLine:
    """Leave every second point out where it is as good as on the chord between its neighbours."""
    middle = np.arange(1, len(line.points_m) - 1, 2)
    chord = 0.5 * (line.points_m[middle - 1] + line.points_m[middle + 1])
    keep = np.ones(len(line.points_m), np.bool_)
    keep[middle[np.hypot(*(line.points_m[middle] - chord).T) < _CHORD_M]] = False
    return replace(
        line,
        station_m=line.station_m[keep],
        points_m=line.points_m[keep],
        heading_rad=line.heading_rad[keep],
        width_m=line.width_m[keep],
    )


def _end(new: dict[int, Floats], lanes: list[NetLane], index: int | None, which: int) -> Floats | None:
    """Return the first or last point of a lane, as it is now."""
    if index is None or not len(lanes[index].points_m):
        return None
    end: Floats = new.get(index, lanes[index].points_m)[which]
    return end


def _write(lane: NetLane, shape: Floats) -> None:
    """Write a shape; heights are those of the old one at the same share of its length."""
    written = lane.element.get("shape", "").split()
    heights = [float(corner.split(",")[2]) for corner in written if corner.count(",") == 2]
    corners = [f"{x:.4f},{y:.4f}" for x, y in shape]
    if heights and len(heights) == len(written):
        old, way = stations(points(lane.element.get("shape", ""))), stations(shape)
        z = np.interp(way / max(way[-1], _SHORTEST_M), old / max(old[-1], _SHORTEST_M), heights)
        corners = [f"{corner},{height:.4f}" for corner, height in zip(corners, z, strict=True)]
    lane.element.set("shape", " ".join(corners))
    if not lane.internal:
        lane.element.set("customShape", "1")  # netedit keeps it so
