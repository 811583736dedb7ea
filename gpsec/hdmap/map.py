"""Compiles a net into the HD map of a run, and keeps compiled maps on disk."""

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np

from gpsec.core import caches
from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.geo import Projector
from gpsec.hdmap.arrays import LaneGraph, LaneSides, MapArrays, MatchIndex, Roads
from gpsec.hdmap.error import EXACT, MapError
from gpsec.hdmap.graph import lane_graph
from gpsec.hdmap.index import build_index
from gpsec.hdmap.net import Lane, read_net
from gpsec.hdmap.polyline import Polyline, measure, resample
from gpsec.hdmap.sides import lane_sides

_MEANING = "net.json"
# Both; netconvert gives the lanes of one edge the mean of their lengths.
_STRETCHED_SHARE, _STRETCHED_M = 0.1, 1.0


@dataclass(frozen=True)
class HDMap:
    """The lanes of a net as arrays.

    Attributes:
        lane_ids: SUMO's ids; the position is the lane's index everywhere else.
        points: ids of lanes that are only a point -> id of the lane behind them.
        lanes: centre lines; layer 0 is true, layer 1 + k has the spacing `spacings_m[k]` and the map's error.
        index: for matching.
        sides: what lies beside each lane.
        graph: what each lane leads to.
        projector: between the net's frame and WGS84.
        spacings_m: of the resampled layers.
        stretched: lanes whose shape is longer or shorter than the length that SUMO counts along by more than a tenth.

    """

    lane_ids: tuple[str, ...]
    points: dict[str, str]
    lanes: MapArrays
    index: MatchIndex
    sides: LaneSides
    graph: LaneGraph
    projector: Projector
    spacings_m: tuple[float, ...]
    stretched: tuple[str, ...]

    @cached_property
    def lane_index(self) -> dict[str, int]:
        """Index of a lane by SUMO's id; a lane that is only a point counts as the one behind it."""
        index = {lane_id: number for number, lane_id in enumerate(self.lane_ids)}
        return index | {point: index[lane_id] for point, lane_id in self.points.items()}

    def roads(self, layer: Ints) -> Roads:
        """Return the map for vehicles whose P profiles have the layers `layer`."""
        return Roads(self.lanes, self.index, self.graph, self.sides, layer)

    def layer(self, spacing_m: float) -> int:
        """Return the layer that is resampled at `spacing_m`."""
        return 1 + self.spacings_m.index(spacing_m)

    def centre_line(self, lane: int, layer: int = 0) -> Floats:
        """Return the (n, 2) points of a lane."""
        first = self.lanes.first[layer, lane]
        run = slice(first, first + self.lanes.segments[layer, lane])
        start = np.stack([self.lanes.x0_m[run], self.lanes.y0_m[run]], axis=1)
        direction = np.stack([self.lanes.dx[run], self.lanes.dy[run]], axis=1)
        return np.concatenate([start, start[-1:] + direction[-1:] * self.lanes.length_m[run][-1]])

    def beside(self, lane: np.ndarray, left: bool) -> Flags:
        """Return (n,) whether there is a lane of either direction beside each of (n,) lanes on that side."""
        sides = self.sides
        same, oncoming = (
            (sides.same_left_m, sides.oncoming_left_m) if left else (sides.same_right_m, sides.oncoming_right_m)
        )
        return cast("Flags", (same[lane] + oncoming[lane]) > 0.0)


def load_map(
    net_file: Path, spacings_m: tuple[float, ...], cache: Path | None = None, error: MapError = EXACT
) -> HDMap:
    """Return the map of a net, compiled now or read from the cache.

    A compiled map lies in a folder named by the content of the net, the spacings, the `error` of the resampled layers
    and the code that compiled it, with digests of its files; big nets load by memory map. The cache is `cache`, or
    `gpsec.core.caches.cache_folder`.

    Raises:
        GpsecError: the net cannot be used (see `read_net`), or the cache cannot.

    """
    spacings = tuple(sorted(set(spacings_m)))
    if not net_file.is_file():
        read_net(net_file)  # says what is wrong
    folder = caches.map_folder(_key(net_file, spacings, error), cache)
    found = _load(folder, net_file)
    if found is None:
        found = compile_map(net_file, spacings, error)
        try:
            _save(found, folder)
        except OSError:
            return found  # the next run compiles it again
    return found


def compile_map(net_file: Path, spacings_m: tuple[float, ...], error: MapError = EXACT) -> HDMap:
    """Return the map of a net with one resampled layer for each spacing, which has the `error`."""
    net = read_net(net_file)
    true = [measure(lane.shape_m) for lane in net.lanes]
    stored = [[resample(line, spacing) for line in true] for spacing in spacings_m]
    layers = [true, *([error.displaced(net.lanes, layer) for layer in stored] if error else stored)]
    arrays = _arrays(net.lanes, layers)
    return HDMap(
        tuple(lane.lane_id for lane in net.lanes),
        net.points,
        arrays,
        build_index(net.lanes, arrays),
        lane_sides(net.lanes),
        lane_graph(net.lanes),
        net.projector,
        spacings_m,
        tuple(lane.lane_id for lane, line in zip(net.lanes, true, strict=True) if _is_stretched(lane, line)),
    )


def _is_stretched(lane: Lane, line: Polyline) -> bool:
    return abs(float(line.s_m[-1]) - lane.length_m) > max(_STRETCHED_SHARE * lane.length_m, _STRETCHED_M)


def _arrays(lanes: list[Lane], layers: list[list[Polyline]]) -> MapArrays:
    lines = [line for layer in layers for line in layer]
    count = np.array([len(line.s_m) - 1 for line in lines], np.int32)
    first = (np.cumsum(count) - count).astype(np.int32)
    start = np.concatenate([line.points_m[:-1] for line in lines])
    step = np.concatenate([np.diff(line.points_m, axis=0) for line in lines])
    length = np.hypot(step[:, 0], step[:, 1])
    led_to = {name for lane in lanes for name in lane.successors}
    open_start, open_end = np.zeros(len(length), np.bool_), np.zeros(len(length), np.bool_)
    open_start[first] = [lane.lane_id not in led_to for lane in lanes] * len(layers)
    open_end[first + count - 1] = [not lane.successors for lane in lanes] * len(layers)
    shape = (len(layers), len(lanes))
    return MapArrays(
        first.reshape(shape),
        count.reshape(shape),
        np.repeat(np.tile(np.arange(len(lanes), dtype=np.int32), len(layers)), count),
        np.ascontiguousarray(start[:, 0]),
        np.ascontiguousarray(start[:, 1]),
        step[:, 0] / length,
        step[:, 1] / length,
        length,
        np.concatenate([line.yaw_rad[:-1] for line in lines]),
        np.concatenate([np.diff(line.yaw_rad) for line in lines]),
        np.concatenate([line.curvature_per_m[:-1] for line in lines]),
        np.concatenate([line.curvature_per_m[1:] for line in lines]),
        open_start,
        open_end,
    )


def _key(net_file: Path, spacings_m: tuple[float, ...], error: MapError) -> str:
    digest = hashlib.sha256(f"{spacings_m} {error if error else EXACT}".encode())
    digest.update(net_file.read_bytes())
    return digest.hexdigest()


def _save(hd_map: HDMap, folder: Path) -> None:
    with caches.new_folder(folder) as part:
        for group in (hd_map.lanes, hd_map.index, hd_map.sides, hd_map.graph):
            for field, array in group._asdict().items():
                np.save(part / f"{type(group).__name__}.{field}.npy", array)
        meaning = {
            "lane_ids": hd_map.lane_ids,
            "points": hd_map.points,
            "projection": hd_map.projector.definition,
            "offset_m": hd_map.projector.offset_m,
            "spacings_m": hd_map.spacings_m,
            "stretched": hd_map.stretched,
        }
        (part / _MEANING).write_text(json.dumps(meaning))


def _load(folder: Path, net_file: Path) -> HDMap | None:
    """Return the map that is kept in a folder; None where there is none, or it is damaged."""
    if not caches.is_whole(folder):
        return None
    try:
        meaning = json.loads((folder / _MEANING).read_text())
        return HDMap(
            tuple(meaning["lane_ids"]),
            dict(meaning["points"]),
            MapArrays(*_read(folder, "MapArrays", MapArrays._fields)),
            MatchIndex(*_read(folder, "MatchIndex", MatchIndex._fields)),
            LaneSides(*_read(folder, "LaneSides", LaneSides._fields)),
            LaneGraph(*_read(folder, "LaneGraph", LaneGraph._fields)),
            Projector(meaning["projection"], tuple(meaning["offset_m"]), str(net_file)),
            tuple(meaning["spacings_m"]),
            tuple(meaning["stretched"]),
        )
    except OSError:
        return None  # another process takes it away


def _read(folder: Path, group: str, fields: tuple[str, ...]) -> list[Any]:
    # Copy-on-write: pages are shared and read on demand, and the arrays have the type that kernels are compiled for.
    return [np.asarray(np.load(folder / f"{group}.{field}.npy", mmap_mode="c")) for field in fields]
