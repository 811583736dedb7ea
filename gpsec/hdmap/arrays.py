"""The HD map as arrays that kernels read."""

from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints


class LaneSides(NamedTuple):
    """What lies beside each of L lanes, in the direction of the lane; widths in metres, 0 where there is none.

    Attributes:
        width_m: (L,) of the lane itself.
        internal: (L,) inside a junction, without markings.
        same_left_m, same_right_m: (L,) total width of the lanes of the same direction on that side.
        oncoming_left_m, oncoming_right_m: (L,) total width of the lanes of the opposite direction beyond those.

    """

    width_m: Floats
    internal: Flags
    same_left_m: Floats
    same_right_m: Floats
    oncoming_left_m: Floats
    oncoming_right_m: Floats


class LaneGraph(NamedTuple):
    """How L lanes hang together.

    Attributes:
        after_first, after_count: (L,) CSR of what each lane leads to; after_lane: those lanes.
        left, right: (L,) next lane of the same edge on that side, -1 where there is none.
    """

    after_first: Ints
    after_count: Ints
    after_lane: Ints
    left: Ints
    right: Ints


class MapArrays(NamedTuple):
    """Lane centre lines in one or more layers; layer 0 is the true geometry, others are resampled for a profile.

    L lanes, Y layers, S segments in all. The segments of lane l in layer y are ``first[y, l]`` up to (not including)
    ``first[y, l] + segments[y, l]``, in driving order.

    Attributes:
        first, segments: (Y, L) CSR of segments.
        lane: (S,) lane of a segment.
        x0_m, y0_m: (S,) start point in the net's frame.
        dx, dy: (S,) unit vector along the segment.
        length_m: (S,) of the segment.
        yaw0_rad, turn_rad: (S,) smoothed lane direction at the start point and its change along the segment.
        curvature0_per_m, curvature1_per_m: (S,) at start and end point, left positive.
        open_start, open_end: (S,) nothing leads to, or on from, this end of the lane.

    """

    first: Ints
    segments: Ints
    lane: Ints
    x0_m: Floats
    y0_m: Floats
    dx: Floats
    dy: Floats
    length_m: Floats
    yaw0_rad: Floats
    turn_rad: Floats
    curvature0_per_m: Floats
    curvature1_per_m: Floats
    open_start: Flags
    open_end: Flags


class Pose(NamedTuple):
    """A vehicle on the map, as it is or as it is believed to be.

    Attributes:
        layer: of the map.
        lane: that the vehicle is believed to be on.
        x_m, y_m: position in the net's frame.
        heading_rad: counter-clockwise from east.

    """

    layer: int
    lane: int
    x_m: float
    y_m: float
    heading_rad: float


class MatchIndex(NamedTuple):
    """What makes the search for the nearest segment fast; it does not change its result.

    Chunks are runs of a lane's segments and groups are runs of its chunks, each with a bounding circle. A lane's chain
    is the lane with what leads to it and on from it within the reach of tracked matching. The grid lists, cell by
    cell, the chunks whose circle touches it.

    Attributes:
        group_first, group_count: (Y, L) CSR of groups.
        group_chunk, group_chunks: (G,) first chunk of a group and their number.
        group_x_m, group_y_m, group_radius_m: (G,) bounding circle.
        chunk_segment, chunk_segments: (C,) first segment of a chunk and their number.
        chunk_x_m, chunk_y_m, chunk_radius_m: (C,) bounding circle.
        chain_first, chain_count: (L,) CSR of chains; chain_lane: their lanes, the lane itself first.
        chain_x_m, chain_y_m, chain_radius_m: circle about the whole of each lane in a chain, in every layer; infinite
            where an end of the lane continues straight on.
        grid_first: (Y, cells + 1) CSR of the grid; grid_chunk: the chunks.
        grid_x_m, grid_y_m, grid_cell_m: (1,) lower left corner and cell size.
        grid_columns, grid_rows: (1,) size in cells.

    """

    group_first: Ints
    group_count: Ints
    group_chunk: Ints
    group_chunks: Ints
    group_x_m: Floats
    group_y_m: Floats
    group_radius_m: Floats
    chunk_segment: Ints
    chunk_segments: Ints
    chunk_x_m: Floats
    chunk_y_m: Floats
    chunk_radius_m: Floats
    chain_first: Ints
    chain_count: Ints
    chain_lane: Ints
    chain_x_m: Floats
    chain_y_m: Floats
    chain_radius_m: Floats
    grid_first: Ints
    grid_chunk: Ints
    grid_x_m: Floats
    grid_y_m: Floats
    grid_cell_m: Floats
    grid_columns: Ints
    grid_rows: Ints


class MapView(NamedTuple):
    """The HD map as vehicles see it.

    Attributes:
        lanes, lookup: the map.
        mode: how to match.
        layer: (P,) the layer of each profile.
    """

    lanes: MapArrays
    lookup: MatchIndex
    mode: int
    layer: Ints


class Roads(NamedTuple):
    """The map with how its lanes hang together.

    Attributes:
        lanes, lookup, graph, sides: the map.
        layer: (P,) the layer of each profile.
    """

    lanes: MapArrays
    lookup: MatchIndex
    graph: LaneGraph
    sides: LaneSides
    layer: Ints
