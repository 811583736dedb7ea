"""Reads the roads of an OpenDRIVE file."""

from math import inf, isfinite
from pathlib import Path
from typing import NoReturn
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, shown
from gpsec.opendrive.curves import Arc, Line, ParamPoly3, Poly3, ReferenceLineCurve, Spiral
from gpsec.opendrive.numbers import check_numbers
from gpsec.opendrive.road import Cubics, Geometry, LaneSection, Road, RoadLane

_CURVES = ("line", "arc", "spiral", "poly3", "paramPoly3")
_MPS = {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704, "": 1.0}
_FASTEST_MPS = 1000.0
SHORTEST_ROAD_M = 1e-6
# Lanes are drawn with points every half metre: some 2.5 GB of them for six lanes.
MOST_ROAD_M = 5e6


def parse(map_file: Path) -> Element:
    """Return the root of an OpenDRIVE file, without namespaces, with its numbers checked.

    Raises:
        GpsecError: it is missing, not XML, or not OpenDRIVE, or a number is none or out of bounds.
    """
    try:
        root: Element = ElementTree.parse(map_file).getroot()
    except OSError as error:
        raise GpsecError(f"{map_file}: cannot be read: {error.strerror or error}") from None
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise GpsecError(f"{map_file}: expected OpenDRIVE, found no XML that can be read ({error})") from None
    for element in root.iter():
        if isinstance(element.tag, str):
            element.tag = element.tag.rpartition("}")[2]
    if root.tag != "OpenDRIVE":
        raise GpsecError(f"{map_file}: expected OpenDRIVE, found <{shown(root.tag)}>")
    if root.find("road") is None:
        raise GpsecError(f"{map_file}: expected at least one road, found none")
    check_numbers(root, map_file)
    return root


def roads(root: Element, map_file: Path) -> list[Road]:
    """Return the roads under an OpenDRIVE root; error messages name `map_file`.

    Widths must be spelt out, and sections complete.

    Roads without a length or a geometry are left out; netconvert does the same.

    Raises:
        GpsecError: a value is missing or no number, a curve is of an unknown kind, or there is more than memory holds.
    """
    found = [_Reader(element, map_file).road() for element in root.iterfind("road")]
    kept = [road for road in found if road is not None]
    total_m = sum(road.length_m for road in kept)
    if total_m > MOST_ROAD_M:
        raise GpsecError(
            f"{map_file}: expected at most {MOST_ROAD_M / 1e3:.0f} km of road, found {total_m / 1e3:.0f} km; "
            "import the map in parts"
        )
    return kept


class _Reader:
    """Reads one road; remembers which, for errors."""

    def __init__(self, element: Element, map_file: Path) -> None:
        self._element = element
        self._where = f"{map_file}: road '{shown(element.get('id', ''))}'"

    def road(self) -> Road | None:
        element = self._element
        length = self._number(element, "length")
        drawn = [self._geometry(item) for item in element.iterfind("planView/geometry")]
        geometries = sorted((item for item in drawn if item is not None), key=lambda item: item.station_m)
        if length <= SHORTEST_ROAD_M or not geometries:
            return None
        return Road(
            element.get("id", ""),
            element.get("junction", "-1"),
            length,
            element.get("rule", "RHT") == "LHT",
            tuple(geometries),
            self._cubics(element, "lanes/laneOffset", "s"),
            self._cubics(element, "lateralProfile/superelevation", "s"),
            self._sections(length),
            tuple(
                (self._number(item, "s", 0.0), self._speed(speed))
                for item in element.iterfind("type")
                if (speed := item.find("speed")) is not None
            ),
        )

    def _geometry(self, element: Element) -> Geometry | None:
        length = self._number(element, "length")
        if length <= SHORTEST_ROAD_M:
            return None
        s, x, y, heading = (self._number(element, key) for key in ("s", "x", "y", "hdg"))
        return Geometry(s, x, y, heading, length, self._curve(element, s, length))

    def _curve(self, geometry: Element, s: float, length: float) -> ReferenceLineCurve:
        shape = next((child for child in geometry if child.tag != "userData"), None)
        if shape is None or shape.tag not in _CURVES:
            found = "none" if shape is None else f"<{shown(shape.tag)}>"
            self._refuse(f"geometry at s={s:g}: expected one of {', '.join(_CURVES)}, found {found}")
        if shape.tag == "line":
            return Line()
        if shape.tag == "arc":
            return Arc(self._number(shape, "curvature"))
        if shape.tag == "spiral":
            return Spiral(self._number(shape, "curvStart"), self._number(shape, "curvEnd"))
        if shape.tag == "poly3":
            return Poly3(self._numbers(shape, "abcd"))
        normalised = shape.get("pRange", "normalized") != "arcLength"
        u, v = (self._numbers(shape, [f"{power}{axis}" for power in "abcd"]) for axis in "UV")
        return ParamPoly3(u, v, 1.0 if normalised else length)

    def _sections(self, length: float) -> tuple[LaneSection, ...]:
        elements = sorted(self._element.iterfind("lanes/laneSection"), key=lambda item: self._number(item, "s"))
        begins = [min(max(self._number(item, "s"), 0.0), length) for item in elements]
        ends = [*begins[1:], length][: len(begins)]
        return tuple(
            LaneSection(begin, end, self._lanes(element, begin))
            for element, begin, end in zip(elements, begins, ends, strict=True)
            if end - begin > SHORTEST_ROAD_M
        )

    def _lanes(self, section: Element, begin: float) -> tuple[RoadLane, ...]:
        lanes = [self._lane(item) for item in section.iter("lane")]
        numbers = [lane.lane_id for lane in lanes]
        if twice := [number for number in numbers if numbers.count(number) > 1]:
            self._refuse(f"laneSection at s={begin:g}: expected one lane of each id, found several with {twice[0]}")
        return tuple(lane for lane in lanes if lane.lane_id != 0)

    def _lane(self, element: Element) -> RoadLane:
        return RoadLane(
            int(self._number(element, "id")),
            element.get("type", "none"),
            self._cubics(element, "width", "sOffset"),
            element.get("level") in ("true", "1"),
            element.get("direction") == "reversed",
            tuple((self._number(item, "sOffset", 0.0), self._speed(item)) for item in element.iterfind("speed")),
            self._linked(element, "predecessor"),
            self._linked(element, "successor"),
            element,
        )

    def _linked(self, element: Element, which: str) -> int | None:
        link = element.find(f"link/{which}")
        return None if link is None else int(self._number(link, "id"))

    def _cubics(self, element: Element, path: str, station: str) -> Cubics:
        return Cubics.of(
            [(self._number(item, station), *self._numbers(item, "abcd")) for item in element.iterfind(path)]
        )

    def _speed(self, element: Element) -> float | None:
        """Return a limit in m/s, None for no limit or an undefined one."""
        written = element.get("max", "undefined")
        unit = element.get("unit", "m/s")
        if written in ("no limit", "undefined"):
            return None
        if unit not in _MPS:
            self._refuse(f"speed: expected one of the units {', '.join(filter(None, _MPS))}, found '{shown(unit)}'")
        limit = self._number(element, "max") * _MPS[unit]
        if limit > _FASTEST_MPS:
            self._refuse(f"speed: expected a limit of at most {_FASTEST_MPS:g} m/s, found '{shown(written)}' {unit}")
        return limit

    def _numbers(self, element: Element, keys: str | list[str]) -> Floats:
        return np.array([self._number(element, key) for key in keys])

    def _number(self, element: Element, key: str, default: float | None = None) -> float:
        written = element.get(key)
        if written is None and default is not None:
            return default
        try:
            value = float(written) if written is not None else inf
        except ValueError:
            value = inf
        if not isfinite(value):
            found = "none" if written is None else f"'{shown(written)}'"
            self._refuse(f"<{element.tag}>: expected a number for '{key}', found {found}")
        return value

    def _refuse(self, sentence: str) -> NoReturn:
        raise GpsecError(f"{self._where}: {sentence}")
