"""The bird's eye: calibration as one mapping from the pixels of a picture to a grid on the road.

The rows of the grid are about as far apart as the picture's own rows are on the road, so that near paint is not thrown
away and far paint not counted over and over.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.opencv import opencv
from gpsec.imaging.pictures.threshold import CORE_M, ROAD_FROM_M, ROAD_M, RidgeRows

ASIDE_M, CELL_M = 6.0, 0.04
"""Half width of the grid, and width of a cell."""
_LEAST_STEP_M = 0.1
# No line of paint is wider.
_WIDEST_M = 0.6


class Marks(NamedTuple):
    """Where a row of the grid crosses something like paint; n of them.

    Attributes:
        x_m, y_m: (n,) ahead and left of the rear axle.
        strength: (n,) 0 … 1, how much it stands out.
        row_m: (n,) length of road that its row stands for.
    """

    x_m: Floats
    y_m: Floats
    strength: Floats
    row_m: Floats


@dataclass(frozen=True)
class BirdsEye:
    """What a camera can see of the lane.

    Attributes:
        camera: calibrated.
        far_m: how far from the rear axle the grid reaches.
    """

    camera: RoadCamera
    far_m: float = 45.0

    @cached_property
    def region(self) -> slice:
        """Rows of the picture that show the road up to `far_m`: the region of interest."""
        camera = self.camera
        rows = np.arange(camera.height)
        ahead = camera.on_road(np.stack([np.full(len(rows), camera.cx), rows], axis=1))[:, 0]
        inside = np.flatnonzero((ahead < self.far_m + 2.0) & (rows < camera.hood_row))
        return slice(int(inside[0]), int(inside[-1]) + 1) if len(inside) else slice(0, 0)

    @cached_property
    def rows(self) -> RidgeRows:
        """How wide paint is in each row of the region, and which columns of it show the grid."""
        camera, region = self.camera, self.region
        rows = np.arange(region.start, region.stop)
        ahead = camera.on_road(np.stack([np.full(len(rows), camera.cx), rows], axis=1))[:, 0]
        scale = camera.fx / np.maximum(ahead - camera.x_m, 0.5)  # pixels a metre
        sides = []
        for y_m in (ASIDE_M, -ASIDE_M):
            at = np.stack([ahead, np.full(len(rows), y_m), np.zeros(len(rows))], axis=1)
            sides.append(np.clip(camera.project(at)[0][:, 0], 0.0, camera.width).astype(np.int32))
        core = np.round(0.5 * CORE_M * scale - 0.5).clip(0.0).astype(np.int32)
        gap = np.maximum(np.round(ROAD_FROM_M * scale), core + 2).astype(np.int32)
        flank = np.maximum(np.round(ROAD_M * scale), 1).astype(np.int32)
        return RidgeRows(core, gap, flank, sides[0], sides[1])

    @cached_property
    def x_m(self) -> Floats:
        """Distance of each row of the grid, nearest first."""
        camera = self.camera
        rows = np.arange(self.region.stop - 1, self.region.start - 1, -1)
        ahead = camera.on_road(np.stack([np.full(len(rows), camera.cx), rows], axis=1))[:, 0]
        kept = [float(ahead[0])] if len(ahead) else []
        for x in ahead.tolist():
            if x - kept[-1] >= _LEAST_STEP_M and x <= self.far_m:
                kept.append(x)
        return np.array(kept)

    @cached_property
    def y_m(self) -> Floats:
        """Each column of the grid, from left to right."""
        columns = np.arange(round(2.0 * ASIDE_M / CELL_M), dtype=np.float64)
        left: Floats = ASIDE_M - CELL_M * (columns + 0.5)
        return left

    @cached_property
    def row_m(self) -> Floats:
        """Length of road that each row stands for."""
        length: Floats = np.asarray(np.gradient(self.x_m), dtype=np.float64)
        return length

    @cached_property
    def _maps(self) -> tuple[np.ndarray, np.ndarray]:
        """The mapping as OpenCV wants it: intrinsics, lens, extrinsics and bird's eye at once."""
        x, y = np.meshgrid(self.x_m, self.y_m, indexing="ij")
        pixels, _ = self.camera.project(np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1))
        pixels[:, 1] -= self.region.start
        shaped = pixels.astype(np.float32).reshape(*x.shape, 2)
        first, second = opencv().convertMaps(shaped, None, opencv().CV_16SC2)
        return first, second

    def seen_from_above(self, score: np.ndarray) -> np.ndarray:
        """Return the grid of a score (R, W) of the region's pixels."""
        cv2 = opencv()
        first, second = self._maps
        grid: np.ndarray = cv2.remap(score, first, second, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return grid

    def marks(self, grid: np.ndarray) -> Marks:
        """Return what is like paint in each row of the grid: runs of cells that are not wider, by their centroids."""
        flat = np.zeros((grid.shape[0], grid.shape[1] + 1), np.uint8)  # an empty column, so that no run turns a corner
        flat[:, :-1] = grid
        values = flat.ravel()
        edge = np.flatnonzero(np.diff(np.concatenate([[False], values > 0])))
        first, last = edge[0::2], edge[1::2]
        if not len(first):
            return Marks(*(np.zeros(0) for _ in Marks._fields))
        columns = np.arange(len(values)) % flat.shape[1]
        mass = np.concatenate([[0], np.cumsum(values, dtype=np.int64)])
        moment = np.concatenate([[0], np.cumsum(values * columns, dtype=np.int64)])
        weight = (mass[last] - mass[first]).astype(np.float64)
        column = (moment[last] - moment[first]) / weight
        row: Ints = first // flat.shape[1]
        narrow = (last - first) * CELL_M <= _WIDEST_M
        strength = np.minimum(weight / 400.0, 1.0)
        row, column, strength = row[narrow], column[narrow], strength[narrow]
        return Marks(self.x_m[row], ASIDE_M - CELL_M * (column + 0.5), strength, self.row_m[row])
