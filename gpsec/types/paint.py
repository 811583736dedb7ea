"""Which lanes have lines on their sides: a file beside the net, `NET.paint.csv`."""

import csv
from collections.abc import Iterable
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from gpsec.core.errors import GpsecError, shown

PAINT_SUFFIX = ".paint.csv"
_COLUMNS = ("lane", "begin_m", "end_m", "left", "right")
_FLAGS = {"0": False, "1": True}


class PaintedLane(NamedTuple):
    """A stretch of a lane.

    Attributes:
        lane: id in the net.
        begin_m, end_m: along its shape.
        left, right: there is a line on that side.
    """

    lane: str
    begin_m: float
    end_m: float
    left: bool
    right: bool


def paint_file(net_file: Path) -> Path:
    """Return where the lines of a net are: beside it."""
    name = net_file.name.removesuffix(".gz").removesuffix(".xml").removesuffix(".net")
    return net_file.with_name(name + PAINT_SUFFIX)


def write_paint(stretches: Iterable[PaintedLane], path: Path) -> None:
    """Write stretches of lanes."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(_COLUMNS)
        for one in stretches:
            table.writerow([one.lane, f"{one.begin_m:.2f}", f"{one.end_m:.2f}", int(one.left), int(one.right)])


def read_paint(path: Path) -> list[PaintedLane]:
    """Return the stretches in a file.

    Raises:
        GpsecError: the file is missing, or a row is not as `write_paint` writes it.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
    except (OSError, ValueError, csv.Error) as error:
        raise GpsecError(f"{path}: expected the lines of a net as CSV, found none: {shown(error)}") from None
    if not rows or tuple(rows[0]) != _COLUMNS:
        raise GpsecError(f"{path}: expected the columns {', '.join(_COLUMNS)}, found others")
    return [_stretch(path, number, row) for number, row in enumerate(rows[1:], start=2)]


def _stretch(path: Path, number: int, row: list[str]) -> PaintedLane:
    try:
        lane, begin, end, left, right = row
        begin_m, end_m = float(begin), float(end)
        if isfinite(begin_m) and isfinite(end_m) and 0.0 <= begin_m <= end_m:
            return PaintedLane(lane, begin_m, end_m, _FLAGS[left], _FLAGS[right])
    except (ValueError, KeyError):
        pass
    raise GpsecError(
        f"{path}: row {number}: expected a lane, 0 <= begin_m <= end_m, and 0 or 1 twice, found"
        f" '{shown(','.join(row))}'"
    )
