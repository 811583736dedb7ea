"""Rewrites lane sections and widths that netconvert does not read, and describes every change."""

from collections.abc import Sequence
from xml.etree.ElementTree import Element

from gpsec.core.errors import shown
from gpsec.opendrive.lanes import IMPORTED
from gpsec.opendrive.road import Road
from gpsec.opendrive.sections import complete_sections
from gpsec.opendrive.widths import NO_TYPE, spell_out_widths

_MOST_NAMED = 3


def spell_out(root: Element) -> list[str]:
    """Complete lane sections of one side and spell out widths; return what was done, one sentence each."""
    single = complete_sections(root)
    widths = spell_out_widths(root)
    both = [
        f"lane {lane.get('id')} of road '{shown(road.get('id'))}'"
        for road in root.iterfind("road")
        for lane in road.iterfind("lanes/laneSection/*/lane")
        if lane.get("direction") == "both" or lane.get("type") == "bidirectional"
    ]
    said = [
        counted("lane sections of one side (singleSide), which netconvert takes for both, completed", single),
        counted("lanes with borders, which netconvert does not read, given their widths", widths.from_border),
        named("lanes with neither width nor border, left out", widths.missing),
        named("lanes whose width is below zero, where they have none now", widths.negative),
        named("lanes whose width begins behind their lane section, with none before", widths.late),
        named("lanes driven in both directions, in the net in that of their side", both),
    ]
    return [sentence for sentence in said if sentence]


def leave_out_reversed(roads: Sequence[Road]) -> list[str]:
    """Take lanes that are driven against their side out of what netconvert reads; return what was done.

    SUMO's lanes of one edge have one direction, and netconvert would turn these round.
    """
    found = [
        (road, lane)
        for road in roads
        for section in road.sections
        for lane in section.lanes
        if lane.reversed and lane.kind in IMPORTED
    ]
    for _, lane in found:
        lane.element.set("type", NO_TYPE)
    names = [f"lane {lane.lane_id} of road '{shown(road.road_id)}'" for road, lane in found]
    sentence = named('lanes driven against their side (direction="reversed"), which a net cannot have, left out', names)
    return [sentence] if sentence else []


def counted(what: str, count: int) -> str:
    """Return a sentence with a count, empty for none."""
    return f"{what}: {count}" if count else ""


def named(what: str, names: Sequence[str]) -> str:
    """Return a sentence with a count and the first names, empty for none."""
    if not names:
        return ""
    some = ", ".join(names[:_MOST_NAMED])
    return f"{what}: {len(names)}" + (f", such as {some}" if len(names) > _MOST_NAMED else f", {some}")
