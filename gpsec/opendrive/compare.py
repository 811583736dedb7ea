"""Compares the lanes of a net with the lane centres of the OpenDRIVE map that it was made from."""

from dataclasses import dataclass

import numpy as np
import shapely

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.opendrive.lanes import CentreLine
from gpsec.opendrive.netfile import NetLane

MATCH_REACH_M = 8.0
# A lane runs along another one where their directions differ by less than 45°.
_ALONG = np.cos(np.pi / 4.0)
# A point that lies further beyond the end of a lane than this is not beside it.
_BEYOND_END_M = 0.3
_TANGENT_M = 0.05


@dataclass(frozen=True)
class Matches:
    """The lane of the net beside each of n points of OpenDRIVE lane centres.

    Attributes:
        lane: (n,) index of the net's lane, -1 where there is none.
        across_m: (n,) how far the net's lane lies to the left, in the direction of travel; 0 where there is none.
        along_m: (n,) where on the net's lane that is.
    """

    lane: Ints
    across_m: Floats
    along_m: Floats

    @property
    def matched(self) -> Flags:
        """(n,) whether there is a lane."""
        found: Flags = self.lane >= 0
        return found


def match_lanes(lines: list[CentreLine], lanes: list[NetLane]) -> Matches:
    """Return the net's lane beside every point of the lines, one after the other.

    It is the lane that netconvert made from this very lane, as far as it goes. Where none is beside the point, it is
    the nearest lane inside a junction within half a lane's width: a path through a junction may be made from several
    roads, of which netconvert names only one.
    """
    points = np.concatenate([line.points_m for line in lines])
    heading = np.concatenate([line.heading_rad for line in lines])
    width = np.concatenate([line.width_m for line in lines])
    names: dict[str, int] = {}
    of_line = [names.setdefault(f"{line.road_id}_{line.lane_id}", len(names)) for line in lines]
    original = np.repeat(of_line, [len(line.points_m) for line in lines])
    usable = [number for number, lane in enumerate(lanes) if len(np.unique(lane.points_m, axis=0)) > 1]
    shapes = np.array([shapely.LineString(lanes[number].points_m) for number in usable], dtype=object)
    made_from = np.array([names.get(lanes[number].original, -1) for number in usable], np.int64)
    internal = np.array([lanes[number].internal for number in usable], np.bool_)

    here = shapely.points(points)
    point, shape = shapely.STRtree(shapes).query(here, predicate="dwithin", distance=MATCH_REACH_M)
    same = made_from[shape] == original[point]
    # Before the expensive part, leave out the lanes that will not be taken anyway.
    point, shape, same = (values[same | internal[shape]] for values in (point, shape, same))
    line = shapes[shape]
    length = shapely.length(line)
    along = shapely.line_locate_point(line, here[point])
    foot = _coordinates(line, along)
    tangent = _coordinates(line, np.minimum(along + _TANGENT_M, length)) - _coordinates(
        line, np.maximum(along - _TANGENT_M, 0.0)
    )
    tangent /= np.hypot(tangent[:, 0], tangent[:, 1])[:, None]
    ahead = np.stack([np.cos(heading[point]), np.sin(heading[point])], axis=1)
    off = foot - points[point]
    across = ahead[:, 0] * off[:, 1] - ahead[:, 1] * off[:, 0]
    clamped = (along <= 0.0) | (along >= length)
    beside = ~clamped | (np.abs((ahead * off).sum(axis=1)) < _BEYOND_END_M)
    near = np.abs(across) <= 0.5 * width[point]
    good = beside & ((tangent * ahead).sum(axis=1) > _ALONG) & (same | near)

    choice = np.flatnonzero(good)
    # Where lanes of one road change their numbers, one of the same number may be another one, a lane's width away.
    rank = np.where(same & near, 0, np.where(near, 1, 2))
    order = choice[np.lexsort((np.abs(across[choice]), rank[choice], point[choice]))]
    first = order[np.unique(point[order], return_index=True)[1]]
    found = np.full(len(points), -1, np.int32)
    lateral, position = np.zeros(len(points)), np.zeros(len(points))
    found[point[first]] = np.array(usable, np.int32)[shape[first]]
    lateral[point[first]], position[point[first]] = across[first], along[first]
    return Matches(found, lateral, position)


def _coordinates(line: np.ndarray, along: Floats) -> Floats:
    place: Floats = shapely.get_coordinates(shapely.line_interpolate_point(line, along))
    return place
