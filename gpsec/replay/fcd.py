"""Reads SUMO's FCD output: where all vehicles are, step by step."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from xml.etree import ElementTree

from gpsec.core.errors import GpsecError, shown
from gpsec.traffic.inputs import UNREADABLE, open_input

_MIN_STEP_S, _MAX_STEP_S = 0.001, 0.2
_NEEDED = ("id", "x", "y", "angle", "speed", "lane")
_TAIL = 1 << 20


@dataclass(frozen=True)
class Seen:
    """A vehicle in a step: SUMO's id, type, front (m, or degrees), angle from north (°), speed and lane."""

    vehicle_id: str
    kind: str
    x: float
    y: float
    angle_deg: float
    speed_mps: float
    lane: str


@dataclass(frozen=True)
class FcdClock:
    """When traffic was written down.

    Attributes:
        step_s: between one step and the next.
        first_s: of the first step; last_s: of the last one, None where that cannot be seen without reading all.
    """

    step_s: float
    first_s: float
    last_s: float | None


def steps(file: Path) -> Iterator[tuple[float, list[Seen]]]:
    """Yield time and vehicles of each step.

    Raises:
        GpsecError: the file is missing or broken, lacks an attribute, or a value is no number.
    """
    try:
        with open_input(file) as stream:
            events = ElementTree.iterparse(stream, events=("start", "end"))
            _, root = next(events)
            if root.tag != "fcd-export":
                raise GpsecError(f"{file}: expected SUMO's FCD output, <fcd-export>, found <{shown(root.tag)}>")
            for event, element in events:
                if event == "end" and element.tag == "timestep":
                    yield _time(file, element), [_seen(file, each) for each in element.iter("vehicle")]
                    root.clear()
    except FileNotFoundError:
        raise GpsecError(f"{file}: no such log") from None
    except StopIteration:
        raise GpsecError(f"{file}: expected SUMO's FCD output, found an empty file") from None
    except UNREADABLE as error:
        raise GpsecError(f"{file}: expected SUMO's FCD output, found XML that cannot be read: {shown(error)}") from None


def read_clock(file: Path) -> FcdClock:
    """Return when traffic was written down, by its first two steps and its end.

    Raises:
        GpsecError: there are no two steps, or they are too far apart.
    """
    times: list[float] = []
    for time_s, _ in steps(file):
        times.append(time_s)
        if len(times) == 2:
            break
    if len(times) < 2:
        raise GpsecError(f"{file}: expected two steps or more, found {len(times)}")
    step_s = round(times[1] - times[0], 6)
    if not _MIN_STEP_S <= step_s <= _MAX_STEP_S:
        raise GpsecError(
            f"{file}: expected steps of {_MIN_STEP_S:g} to {_MAX_STEP_S:g} s, for which the filters are valid, found"
            f" {step_s:g} s; run SUMO with --step-length 0.1 and --device.fcd.period 0.1"
        )
    return FcdClock(step_s, times[0], _last_s(file))


def _last_s(file: Path) -> float | None:
    with file.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(max(size - _TAIL, 0))
        found = re.findall(rb'<timestep time="([0-9.]+)"', stream.read())
    return float(found[-1]) if found else None


def _time(file: Path, element: ElementTree.Element) -> float:
    return _number(file, "timestep", element, "time")


def _seen(file: Path, element: ElementTree.Element) -> Seen:
    for name in _NEEDED:
        if element.get(name) is None:
            raise GpsecError(
                f"{file}: vehicle '{shown(element.get('id', ''))}': expected the attribute {name}, found none; SUMO's"
                " --fcd-output.attributes leaves it out"
            )
    x, y, angle_deg, speed_mps = (_number(file, "vehicle", element, name) for name in ("x", "y", "angle", "speed"))
    return Seen(element.attrib["id"], element.get("type", ""), x, y, angle_deg, speed_mps, element.attrib["lane"])


def _number(file: Path, tag: str, element: ElementTree.Element, name: str) -> float:
    text = element.get(name, "")
    try:
        value = float(text)
        if isfinite(value):
            return value
    except ValueError:
        pass
    who = f" '{shown(element.get('id'))}'" if element.get("id") else ""
    raise GpsecError(f"{file}: {tag}{who}: {name}: expected a number, found '{shown(text)}'")
