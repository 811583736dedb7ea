"""Lanes in the pictures of a folder or a video: a table, and the pictures with the lanes in them."""

import csv
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from gpsec.core.errors import GpsecError
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.frames import Frames
from gpsec.imaging.pictures.lanes import LaneFinder, SeenLane
from gpsec.imaging.pictures.memory import LaneMemory
from gpsec.imaging.pictures.overlay import Drawn

LANES = "lanes.csv"
_COLUMNS = ("frame", "t_s", "c0_m", "c1", "c2_per_m", "c3_per_m2", "width_m", "sigma_m", "valid")


@dataclass(frozen=True)
class Detected:
    """What was found in a number of pictures.

    Attributes:
        pictures, lanes: how many there were, and in how many of them a lane.
        jitter_m: standard deviation of C0 from one picture to the next, over √2; None for fewer than two in a row.
    """

    pictures: int
    lanes: int
    jitter_m: float | None


def detect_lanes(
    frames: Frames,
    camera: RoadCamera,
    folder: Path,
    *,
    width_m: float | None = None,
    memory_m: float | None = None,
    overlay: str = "none",
    tell: Callable[[int, int], None] = lambda done, of: None,
) -> Detected:
    """Write `lanes.csv` into `folder`, which is there, and pictures or a film of what was found.

    Args:
        frames: the pictures.
        camera: that took them.
        folder: to write into.
        width_m: of the lane, where it is known.
        memory_m: way over which what was seen is averaged; it takes frames that say how the vehicle moved.
        overlay: one of `pictures.overlay.OVERLAYS`.
        tell: hears how many pictures are done, of how many.

    Raises:
        GpsecError: a picture cannot be read or is of another size, or nothing can be written.
    """
    finder = LaneFinder(camera)
    memory = LaneMemory(memory_m) if memory_m else None
    offsets: list[float | None] = []
    with ExitStack() as stack:
        file = stack.enter_context((folder / LANES).open("w", newline="", encoding="utf-8"))
        table = csv.writer(file, lineterminator="\n")
        table.writerow(_COLUMNS)
        film = stack.enter_context(Drawn(folder, camera, frames.rate_hz, overlay))
        for number, shot in enumerate(frames.shots(camera), start=1):
            if memory is not None and shot.moved is None and number > 1:
                raise GpsecError(
                    f"{frames.path}: --memory takes frames of `gpsec image render`, which say how they moved"
                )
            seen = finder.find(shot.picture, width_m)
            if memory is not None:
                seen = memory.take(seen, shot.moved)
            offsets.append(float(seen.poly[0]) if seen.valid else None)
            table.writerow([shot.name, f"{shot.time_s:.3f}", *_cells(seen)])
            film.add(shot.name, shot.picture, seen)
            tell(number, max(frames.count, number))
    steps = [b - a for a, b in pairwise(offsets) if a is not None and b is not None]
    jitter = float(np.std(steps) / np.sqrt(2.0)) if len(steps) > 1 else None
    return Detected(len(offsets), sum(offset is not None for offset in offsets), jitter)


def _cells(seen: SeenLane) -> list[str]:
    if not seen.valid:
        return ["", "", "", "", "", "", "0"]
    return [*(f"{value:.6g}" for value in seen.poly.tolist()), f"{seen.width_m:.3f}", f"{seen.sigma_m:.4f}", "1"]
