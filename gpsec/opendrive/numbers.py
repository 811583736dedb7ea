"""Checks the numbers of an OpenDRIVE file: which keys have one, and its bounds.

Signals are not among them: one that cannot be read is left out, not the map (`gpsec.opendrive.simplify`).

Between `check_numbers` and the writing of the net nobody has to expect that a number is none, or that a station, a
length or a curvature is so large that it fills the memory.
"""

from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from xml.etree.ElementTree import Element

from gpsec.core.errors import GpsecError, shown

LONGEST_M = 1e6
"""A longer road is a slip of the pen."""

FARTHEST_M = 1e8
"""More than twice around the Earth."""

WIDEST_M = 100.0
"""Of a lane, as in a net."""

_MOST_LANES = 10_000
# Stations that were computed may lie a little before the beginning.
_BEFORE_M = 0.01
_Bounds = tuple[float, float]
_STATION: _Bounds = (-_BEFORE_M, LONGEST_M)
_LENGTH: _Bounds = (-_BEFORE_M, LONGEST_M)
_PLACE: _Bounds = (-FARTHEST_M, FARTHEST_M)
_CURVATURE: _Bounds = (-1e3, 1e3)
# Radians; beyond this, turns are all that is left of a double.
_ANGLE: _Bounds = (-1e6, 1e6)
_ROLL: _Bounds = (-1.6, 1.6)
_LANE: _Bounds = (-_MOST_LANES, _MOST_LANES)
# A cubic may have any coefficients as long as its values are sensible, which is checked where it is evaluated.
_ANY: _Bounds = (-1e30, 1e30)
_CUBIC = dict.fromkeys("abcd", _ANY)

_NUMBERS: dict[str, dict[str, _Bounds]] = {
    "road": {"length": _LENGTH},
    "geometry": {"s": _STATION, "x": _PLACE, "y": _PLACE, "hdg": _ANGLE, "length": _LENGTH},
    "arc": {"curvature": _CURVATURE},
    "spiral": {"curvStart": _CURVATURE, "curvEnd": _CURVATURE},
    "poly3": _CUBIC,
    "paramPoly3": {f"{power}{axis}": _ANY for axis in "UV" for power in "abcd"},
    "elevation": {"s": _STATION} | _CUBIC,
    "superelevation": {"s": _STATION} | _CUBIC | {"a": _ROLL},
    "laneOffset": {"s": _STATION} | _CUBIC,
    "laneSection": {"s": _STATION},
    "lane": {"id": _LANE},
    "width": {"sOffset": _STATION} | _CUBIC,
    "border": {"sOffset": _STATION} | _CUBIC,
    "type": {"s": _STATION},
    "laneLink": {"from": _LANE, "to": _LANE},
}
# Elements of these names mean something else in other places.
_BY_PARENT: dict[tuple[str, str], dict[str, _Bounds]] = {
    ("link", "predecessor"): {"id": _LANE},
    ("link", "successor"): {"id": _LANE},
    ("lane", "speed"): {"sOffset": _STATION},
    ("header", "offset"): {"x": _PLACE, "y": _PLACE, "hdg": _ANGLE},
}
_DEEPEST = 50


def check_numbers(root: Element, map_file: Path) -> None:
    """Check every number under an OpenDRIVE root that is read here or written anew for netconvert.

    Raises:
        GpsecError: one is no number, or no lane id a whole one, or it is out of bounds; names the road and the key.
    """
    for top in root:
        if not isinstance(top.tag, str):
            continue
        name = f" '{shown(top.get('id'))}'" if top.get("id") else ""
        where = f"{map_file}: {shown(top.tag)}{name}"
        for parent, element, depth in _below(top):
            if depth > _DEEPEST:
                raise GpsecError(f"{where}: expected elements at most {_DEEPEST} deep in each other, found more")
            for key, bounds in (_BY_PARENT.get((parent, element.tag)) or _NUMBERS.get(element.tag, {})).items():
                written = element.get(key)
                if written is not None and not _fits(written, bounds):
                    raise GpsecError(f"{where}: <{element.tag}>: {_expected(bounds, key)}, found '{shown(written)}'")


def _below(top: Element) -> Iterator[tuple[str, Element, int]]:
    """Yield every element from `top` on, with the name of the one that it is in, and how deep."""
    waiting = [("", top, 0)]
    while waiting:
        parent, element, depth = waiting.pop()
        if isinstance(element.tag, str):
            yield parent, element, depth
            waiting += [(element.tag, child, depth + 1) for child in element]


def _fits(written: str, bounds: _Bounds) -> bool:
    try:
        value = float(written)
    except ValueError:
        return False
    # Python reads more than XML's numbers.
    if "_" in written or not written.isascii() or not isfinite(value):
        return False
    return bounds[0] <= value <= bounds[1] and (bounds is not _LANE or value == int(value))


def _expected(bounds: _Bounds, key: str) -> str:
    if bounds is _ANY:
        return f"expected a number for '{key}'"
    kind = "whole number" if bounds is _LANE else "number"
    return f"expected a {kind} from {bounds[0]:g} to {bounds[1]:g} for '{key}'"
