"""Writes the speed limits of an OpenDRIVE map in a form that netconvert reads.

This happens on a copy; the user's map is not touched. Every change is said.
"""

from dataclasses import dataclass
from xml.etree.ElementTree import SubElement

from gpsec.opendrive.road import LaneSection, Road, RoadLane

# "no limit" is a German motorway, where 130 km/h is advised.
NO_LIMIT_MPS = 130.0 / 3.6


@dataclass(frozen=True)
class Speeds:
    """What was changed of the speed limits.

    Attributes:
        from_road: lanes that got the limit of their road's type, which netconvert does not read.
        not_positive: lanes that had a limit of 0 or less.
        unlimited: lanes without a limit, which got `NO_LIMIT_MPS`.
    """

    from_road: int
    not_positive: int
    unlimited: int


def spell_out_speeds(roads: list[Road]) -> Speeds:
    """Write into every lane of a map the limit that holds for it; return what was changed."""
    counts = [0, 0, 0]
    for road in roads:
        for section in road.sections:
            for lane in section.lanes:
                changed = _spell_out(lane, road, section)
                counts = [count + change for count, change in zip(counts, changed, strict=True)]
    return Speeds(*counts)


def _spell_out(lane: RoadLane, road: Road, section: LaneSection) -> tuple[bool, bool, bool]:
    """Write the limits of one lane; return what of `Speeds` it counts for."""
    good = [(distance, speed) for distance, speed in lane.speeds if speed is None or speed > 0.0]
    not_positive = len(good) < len(lane.speeds)
    limits, from_road = good, False
    if not good:
        limits = _of_road(road, section)
        from_road = bool(limits)
    unlimited = any(speed is None for _, speed in limits)
    if not (not_positive or from_road or unlimited):
        return False, False, False
    for speed in lane.element.findall("speed"):
        lane.element.remove(speed)
    for number, (distance, limit) in enumerate(limits):
        text = f"{NO_LIMIT_MPS if limit is None else limit:.4f}"
        # netconvert needs a limit from the very beginning.
        SubElement(lane.element, "speed", sOffset=f"{distance if number else 0.0:.4f}", max=text, unit="m/s")
    return from_road, not_positive, unlimited


def _of_road(road: Road, section: LaneSection) -> list[tuple[float, float | None]]:
    """Return (distance from the beginning of the section, limit) of the road's types that it runs through."""
    usable = [(station, speed) for station, speed in sorted(road.speeds, key=_station) if speed is None or speed > 0.0]
    inside = [(station - section.begin_m, speed) for station, speed in usable if station < section.end_m]
    before = [limit for limit in inside if limit[0] <= 0.0]
    return [(0.0, limit) for _, limit in before[-1:]] + [limit for limit in inside if limit[0] > 0.0]


def _station(record: tuple[float, float | None]) -> float:
    return record[0]
