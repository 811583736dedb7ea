"""Widths of lanes, spelt out: netconvert does not read borders, and gives a lane without a width one of its own."""

from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from gpsec.arrays import Floats
from gpsec.errors import shown
from gpsec.opendrive.road import Cubics
from gpsec.opendrive.sections import lane_number

_POWERS = "abcd"
NO_TYPE = "none"
_AT_ONCE_M = 1e-3


@dataclass
class Widths:
    """What became of the widths.

    Attributes:
        from_border: lanes whose width is what lies between their border and that of the next lane inside.
        missing: lanes with neither, by name, which are left out.
        late: lanes whose width begins behind their section, by name; before that they have none.
    """

    from_border: int = 0
    missing: list[str] = field(default_factory=list)
    late: list[str] = field(default_factory=list)


def spell_out_widths(root: Element) -> Widths:
    """Give every lane widths, from its border where it has none; leave lanes out that have neither."""
    said = Widths()
    for road in root.iterfind("road"):
        for section in road.iterfind("lanes/laneSection"):
            lanes = sorted(section.iter("lane"), key=lambda lane: abs(lane_number(lane)))
            for side in (1, -1):
                inner = Cubics.of([])
                for lane in lanes:
                    if lane_number(lane) * side > 0:
                        inner = _spell_out(
                            lane, side, inner, f"lane {lane_number(lane)} of road '{shown(road.get('id'))}'", said
                        )
    return said


def _spell_out(lane: Element, side: int, inner: Cubics, name: str, said: Widths) -> Cubics:
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
    elif width.start_m[0] > _AT_ONCE_M:
        said.late.append(name)
    return _sum(inner, 1, width, 1)


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
