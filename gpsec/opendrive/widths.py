"""Writes the widths of lanes: netconvert reads no borders, and gives a lane without a width one of its own."""

import itertools
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import shown
from gpsec.opendrive.numbers import WIDEST_M
from gpsec.opendrive.road import Cubics
from gpsec.opendrive.sections import lane_number

_POWERS = "abcd"
NO_TYPE = "none"
_AT_ONCE_M = 1e-3
# Curves that were fitted to a lane that closes end a little below zero, which does no harm.
_BELOW_ZERO_M = 0.01
_NOTHING_M = 1e-9


@dataclass
class Widths:
    """What was changed of the widths.

    Attributes:
        from_border: lanes whose width is what lies between their border and that of the next lane inside.
        missing: lanes with neither, by name, which are left out.
        late: lanes whose width begins behind their section, by name; before that they have none.
        negative: lanes whose width is below zero somewhere in their section, by name; it is zero there now.
    """

    from_border: int = 0
    missing: list[str] = field(default_factory=list)
    late: list[str] = field(default_factory=list)
    negative: list[str] = field(default_factory=list)


def spell_out_widths(root: Element) -> Widths:
    """Give every lane widths, from its border where it has none; leave lanes out that have neither."""
    said = Widths()
    for road in root.iterfind("road"):
        sections = road.findall("lanes/laneSection")
        begins = [float(section.get("s", "nan")) for section in sections]
        for section, begin in zip(sections, begins, strict=True):
            end = min((other for other in begins if other > begin), default=float(road.get("length", "nan")))
            lanes = sorted(section.iter("lane"), key=lambda lane: abs(lane_number(lane)))
            for side in (1, -1):
                inner = Cubics.of([])
                for lane in lanes:
                    if lane_number(lane) * side > 0:
                        name = f"lane {lane_number(lane)} of road '{shown(road.get('id'))}'"
                        inner = _spell_out(lane, side, inner, end - begin, name, said)
    return said


def _spell_out(lane: Element, side: int, inner: Cubics, length_m: float, name: str, said: Widths) -> Cubics:
    """Give one lane its width; return how far its outer border is from the centre lane, as `inner` is of the last."""
    width, border = _read(lane, "width"), _read(lane, "border")
    if not len(width.start_m) and len(border.start_m):
        width = _sum(border, side, inner, -1)
        for item in lane.findall("border"):
            lane.remove(item)
        _write(lane, width)
        said.from_border += 1
    elif not len(width.start_m):
        said.missing.append(name)
        lane.set("type", NO_TYPE)
        width = Cubics.of([(0.0, 0.0, 0.0, 0.0, 0.0)])
        _write(lane, width)
    positive = _not_below_zero(width, length_m)
    if positive is not width:
        said.negative.append(name)
        for item in lane.findall("width"):
            lane.remove(item)
        _write(lane, positive)
    if _begins_late(positive, length_m):
        said.late.append(name)
    return _sum(inner, 1, positive, 1)


def _not_below_zero(width: Cubics, length_m: float) -> Cubics:
    """Return a width with zero wherever it is below, within the first `length_m`; itself where it is so nowhere.

    A lane has no negative width. netconvert gives one that has 3.65 m, across others.
    """
    records: list[tuple[float, ...]] = []
    clipped = False
    ends = [*width.start_m[1:], length_m]
    for start, end, values in zip(width.start_m, ends, width.coefficients, strict=True):
        long = max(min(end, length_m) - start, 0.0)
        bends = _zeros(np.polynomial.polynomial.polyder(values), long)
        lowest = np.polynomial.polynomial.polyval(np.array([0.0, *bends, long]), values).min()
        if long == 0.0 or lowest > -_BELOW_ZERO_M:
            records.append((start, *values))
            continue
        if lowest < -WIDEST_M:  # no slip of a fit: the map is refused where its lanes are evaluated
            return width
        clipped = True
        for one, other in itertools.pairwise([0.0, *_zeros(values, long), long]):
            below = np.polynomial.polynomial.polyval((one + other) / 2.0, values) < 0.0
            records.append((start + one, *(np.zeros(4) if below else Cubics.of([(0.0, *values)]).about(one))))
    return Cubics.of(records) if clipped else width


def _zeros(values: Floats, long_m: float) -> list[float]:
    """Return where the polynomial of these coefficients, the lowest first, is zero between 0 and `long_m`."""
    much = np.abs(values) * long_m ** np.arange(len(values)) > _NOTHING_M
    if not much[1:].any():
        return []
    found = np.polynomial.polynomial.polyroots(values[: int(np.flatnonzero(much)[-1]) + 1])
    real = np.sort(found.real[np.abs(found.imag) < _AT_ONCE_M])
    return [float(at) for at in real if 0.0 < at < long_m]


def _begins_late(width: Cubics, length_m: float) -> bool:
    """Return whether the width is zero at first and then jumps."""
    some = np.flatnonzero(np.any(width.coefficients != 0.0, axis=1))
    if not len(some) or not width.start_m[some[0]] < length_m:
        return False
    return bool(width.start_m[some[0]] > _AT_ONCE_M and (some[0] == 0 or width.coefficients[some[0], 0] > _AT_ONCE_M))


def _read(lane: Element, tag: str) -> Cubics:
    keys = ("sOffset", *_POWERS)
    return Cubics.of([tuple(float(item.get(key, "nan")) for key in keys) for item in lane.iterfind(tag)])


def _sum(one: Cubics, of_one: int, other: Cubics, of_other: int) -> Cubics:
    """Return the piecewise cubic of_one·one + of_other·other."""
    starts = np.unique(np.concatenate([one.start_m, other.start_m]))
    values: list[Floats] = [of_one * one.about(at) + of_other * other.about(at) for at in starts]
    return Cubics(starts, np.array(values).reshape(-1, 4))


def _write(lane: Element, width: Cubics) -> None:
    for at, values in zip(width.start_m, width.coefficients, strict=True):
        keys = ("sOffset", *_POWERS)
        SubElement(lane, "width", {key: repr(float(value)) for key, value in zip(keys, (at, *values), strict=True)})
