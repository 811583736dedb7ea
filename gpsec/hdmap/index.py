"""Builds what makes the search for the nearest segment fast."""

from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.hdmap.arrays import MapArrays, MatchIndex
from gpsec.hdmap.net import Lane

CHUNK_SEGMENTS = 4
GROUP_CHUNKS = 4
GRID_CELL_M = 16.0
# How far tracked matching follows what leads to a lane and on from it.
REACH_M = 100.0


@dataclass(frozen=True)
class Circles:
    """Bounding circles of n runs of points: (n,) arrays."""

    x_m: Floats
    y_m: Floats
    radius_m: Floats


def build_index(lanes: list[Lane], arrays: MapArrays) -> MatchIndex:
    """Return the index of a map of these lanes."""
    layers = arrays.first.shape[0]
    chunks, chunk_segment, chunk_segments = _runs(arrays.first, arrays.segments, CHUNK_SEGMENTS)
    groups, group_chunk, group_chunks = _runs(*chunks, GROUP_CHUNKS)
    chunk_circles = _circles(arrays, chunk_segment)
    group_circles = _circles(arrays, chunk_segment[group_chunk])
    lane_circles = _lane_circles(arrays)
    (group_first, group_count), (chain_first, chain_count, chain_lane) = groups, _chains(lanes)
    layer: Ints = np.repeat(np.arange(layers, dtype=np.int32), chunks[1].sum(axis=1))
    return MatchIndex(
        group_first,
        group_count,
        group_chunk,
        group_chunks,
        group_circles.x_m,
        group_circles.y_m,
        group_circles.radius_m,
        chunk_segment,
        chunk_segments,
        chunk_circles.x_m,
        chunk_circles.y_m,
        chunk_circles.radius_m,
        chain_first,
        chain_count,
        chain_lane,
        lane_circles.x_m[chain_lane],
        lane_circles.y_m[chain_lane],
        lane_circles.radius_m[chain_lane],
        *_grid(chunk_circles, layer, layers),
    )


def _runs(first: Ints, count: Ints, size: int) -> tuple[tuple[Ints, Ints], Ints, Ints]:
    """Cut the items ``first … first + count - 1`` of each lane and layer into runs of at most `size`.

    Returns the CSR (first, count) of the runs, and first item and number of items of each run.
    """
    runs = -(-count // size)
    run_first = np.cumsum(runs.ravel()).reshape(runs.shape) - runs
    owner = np.repeat(np.arange(runs.size), runs.ravel())
    done = (np.arange(len(owner)) - run_first.ravel()[owner]) * size
    items = np.minimum(size, count.ravel()[owner] - done)
    csr = run_first.astype(np.int32), runs.astype(np.int32)
    return csr, (first.ravel()[owner] + done).astype(np.int32), items.astype(np.int32)


def _ends(arrays: MapArrays) -> tuple[Floats, Floats]:
    return arrays.x0_m + arrays.dx * arrays.length_m, arrays.y0_m + arrays.dy * arrays.length_m


def _circles(arrays: MapArrays, first: Ints) -> Circles:
    """Return circles about the boxes of runs of segments; each ends where the next one begins."""
    x1, y1 = _ends(arrays)
    bounds = []
    for start, end in ((arrays.x0_m, x1), (arrays.y0_m, y1)):
        low = np.minimum.reduceat(np.minimum(start, end), first)
        high = np.maximum.reduceat(np.maximum(start, end), first)
        bounds.append((low, high))
    (xl, xh), (yl, yh) = bounds
    return Circles(0.5 * (xl + xh), 0.5 * (yl + yh), 0.5 * np.hypot(xh - xl, yh - yl) + 1e-6)


def _lane_circles(arrays: MapArrays) -> Circles:
    """Return a circle about each lane that holds it in every layer."""
    every = _circles(arrays, arrays.first.ravel())
    lanes = arrays.first.shape[1]
    first = arrays.first[0]
    x_m, y_m, radius_m = (part.reshape(-1, lanes) for part in (every.x_m, every.y_m, every.radius_m))
    reach_m = (np.hypot(x_m - x_m[0], y_m - y_m[0]) + radius_m).max(axis=0)
    endless = arrays.open_start[first] | arrays.open_end[first + arrays.segments[0] - 1]
    return Circles(x_m[0], y_m[0], np.where(endless, np.inf, reach_m))


def _chains(lanes: list[Lane]) -> tuple[Ints, Ints, Ints]:
    number = {lane.lane_id: index for index, lane in enumerate(lanes)}
    length = [float(np.hypot(*np.diff(lane.shape_m, axis=0).T).sum()) for lane in lanes]
    after = [[number[name] for name in lane.successors] for lane in lanes]
    before: list[list[int]] = [[] for _ in lanes]
    for index, targets in enumerate(after):
        for target in targets:
            before[target].append(index)
    chains: list[list[int]] = []
    for index in range(len(lanes)):
        reached = dict.fromkeys([index, *_within_reach(index, before, length), *_within_reach(index, after, length)])
        chains.append(list(reached))
    count = np.array([len(chain) for chain in chains], np.int32)
    first = (np.cumsum(count) - count).astype(np.int32)
    return first, count, np.array([lane for chain in chains for lane in chain], np.int32)


def _within_reach(start: int, links: list[list[int]], length: list[float]) -> list[int]:
    """Return lanes that begin less than `REACH_M` from the end of lane `start`, nearest first."""
    queue = [(0.0, lane) for lane in links[start]]
    queue.sort()
    done: dict[int, float] = {}
    while queue:
        distance, lane = heappop(queue)
        if lane in done or distance > REACH_M:
            continue
        done[lane] = distance
        for following in links[lane]:
            heappush(queue, (distance + length[lane], following))
    return list(done)


def _grid(chunks: Circles, layer: Ints, layers: int) -> tuple[Ints, Ints, Floats, Floats, Floats, Ints, Ints]:
    x_low = float((chunks.x_m - chunks.radius_m).min())
    y_low = float((chunks.y_m - chunks.radius_m).min())
    columns = int((float((chunks.x_m + chunks.radius_m).max()) - x_low) // GRID_CELL_M) + 1
    rows = int((float((chunks.y_m + chunks.radius_m).max()) - y_low) // GRID_CELL_M) + 1
    left = ((chunks.x_m - chunks.radius_m - x_low) // GRID_CELL_M).astype(np.int64)
    right = ((chunks.x_m + chunks.radius_m - x_low) // GRID_CELL_M).astype(np.int64)
    bottom = ((chunks.y_m - chunks.radius_m - y_low) // GRID_CELL_M).astype(np.int64)
    top = ((chunks.y_m + chunks.radius_m - y_low) // GRID_CELL_M).astype(np.int64)
    wide, high = right - left + 1, top - bottom + 1
    owner = np.repeat(np.arange(len(left)), wide * high)
    position = np.arange(len(owner)) - np.repeat(np.cumsum(wide * high) - wide * high, wide * high)
    column = left[owner] + position % wide[owner]
    row = bottom[owner] + position // wide[owner]
    cell = (layer[owner] * rows + row) * columns + column
    order = np.argsort(cell, kind="stable")
    starts = np.searchsorted(cell[order], np.arange(layers * rows * columns + 1))
    return (
        starts.astype(np.int32),
        owner[order].astype(np.int32),
        np.array([x_low]),
        np.array([y_low]),
        np.array([GRID_CELL_M]),
        np.array([columns], np.int32),
        np.array([rows], np.int32),
    )
