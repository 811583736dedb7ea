"""What netconvert stumbles over is put in a form that it takes."""

from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pytest

from gpsec.opendrive.curves import Arc, Spiral
from gpsec.opendrive.importing import import_map
from gpsec.opendrive.read import parse
from gpsec.opendrive.simplify import simplify

from .maps import LINE, TWO_WAY, document, road, write

GOOD = {"id": "7", "type": "274", "orientation": "+", "dynamic": "no", "s": "50", "t": "-4"}


def element(tag: str, attributes: dict[str, str], inside: str = "") -> str:
    written = " ".join(f'{key}="{value}"' for key, value in attributes.items())
    return f"<{tag} {written}>{inside}</{tag}>"


def simplified(folder: Path, beside: str = "", geometry: str = LINE) -> tuple[Element, list[str]]:
    text = document(road(TWO_WAY, geometry)).replace("</lanes>", f"</lanes>{beside}")
    root = parse(write(folder, text))
    return root, simplify(root)


def signals(root: Element) -> list[str]:
    return [signal.tag for signal in root.iterfind("road/signals/")]


@pytest.mark.parametrize(
    "changed",
    [{"type": ""}, {"id": ""}, {"orientation": ""}, {"dynamic": ""}, {"s": ""}, {"s": "nan"}, {"s": "here"}],
)
def test_signal_that_netconvert_cannot_read_is_left_out(tmp_path: Path, changed: dict[str, str]) -> None:
    beside = f"<signals>{element('signal', GOOD)}{element('signal', {**GOOD, 'id': '8', **changed})}</signals>"
    root, said = simplified(tmp_path, beside)
    assert signals(root) == ["signal"]
    assert said == ["signals without an id, a type, an orientation or a place, left out: 1"]


def test_reference_goes_with_its_signal(tmp_path: Path) -> None:
    kept, lost = ({"id": name, "orientation": "+", "s": "9"} for name in ("7", "8"))
    untyped = {**GOOD, "id": "8", "type": ""}
    drawn = (("signalReference", kept), ("signalReference", lost), ("signal", GOOD), ("signal", untyped))
    root, said = simplified(tmp_path, f"<signals>{''.join(element(*item) for item in drawn)}</signals>")
    assert signals(root) == ["signalReference", "signal"]
    assert said[0].endswith("left out: 2")


@pytest.mark.parametrize(
    ("lanes", "stays"), [('fromLane="-2" toLane="1"', True), ('fromLane="x" toLane="1"', False), ("", False)]
)
def test_lanes_of_a_signal_are_whole_numbers(tmp_path: Path, lanes: str, stays: bool) -> None:
    root, said = simplified(tmp_path, f"<signals>{element('signal', GOOD, f'<validity {lanes}/>')}</signals>")
    assert bool(signals(root)) == stays
    assert bool(said) != stays


def test_objects_are_left_out(tmp_path: Path) -> None:
    root, said = simplified(tmp_path, '<objects><object id="1"><repeat distance="1e-9" length="5"/></object></objects>')
    assert root.find("road/objects") is None
    assert said == []


@pytest.mark.parametrize(
    ("written", "kind"),
    [
        ('<spiral curvStart="0.01" curvEnd="0.01"/>', "arc"),
        ('<spiral curvStart="0.01" curvEnd="0.010000000001"/>', "arc"),
        ('<spiral curvStart="0" curvEnd="0"/>', "line"),
        ('<spiral curvStart="-0.01" curvEnd="0.01"/>', "spiral"),
        ('<arc curvature="0"/>', "line"),
        ('<arc curvature="1e-17"/>', "line"),
        ('<arc curvature="-1e-5"/>', "arc"),
    ],
)
def test_curves_that_are_simpler_than_they_say(tmp_path: Path, written: str, kind: str) -> None:
    root, said = simplified(tmp_path, geometry=LINE.replace("<line/>", written))
    shape = root.find("road/planView/geometry/")
    assert shape is not None
    assert shape.tag == kind
    assert bool(said) == (kind not in written)


def test_arc_instead_of_a_spiral_ends_where_the_spiral_does() -> None:
    # The greatest change of curvature over 100 m for which an arc is written.
    start, length = 0.02, 100.0
    end = start + 12.0 * 1e-5 / length**2
    way = np.array([length])
    spiral, arc = Spiral(start, end).course(way, length), Arc(0.5 * (start + end)).course(way, length)
    assert np.hypot(spiral.u_m - arc.u_m, spiral.v_m - arc.v_m)[0] < 1.1e-5


def linked(number: str, x: float, lanes: str = TWO_WAY, before: str = "", behind: str = "") -> str:
    ends = (("predecessor", "end", before), ("successor", "start", behind))
    links = "".join(
        f'<{which} elementType="road" elementId="{name}" contactPoint="{point}"/>'
        for which, point, name in ends
        if name
    )
    drawn = road(lanes, LINE.replace('x="0"', f'x="{x}"'), number=number)
    return drawn.replace("<planView>", f"<link>{links}</link><planView>")


def test_roads_without_lane_sections_are_no_crash(tmp_path: Path) -> None:
    roads = linked("1", 0, behind="2"), linked("2", 100, "", "1", "3"), linked("3", 200, before="2")
    text = document(*roads, linked("4", 300).replace("<lanes>", "").replace("</lanes>", "").replace(TWO_WAY, ""))
    done = import_map(
        write(tmp_path, text),
        tmp_path / "map.net.xml",
        origin_deg=None,
        alarm_m={},
        overwrite=False,
        tell=lambda stage: None,
    )
    assert done.lanes == 4
    assert done.check.overall.unmatched_share == 0.0


def test_links_to_roads_that_are_not_there_are_left_out(tmp_path: Path) -> None:
    ways = "".join(
        f'<connection id="0" incomingRoad="{one}" connectingRoad="{other}" contactPoint="start"/>'
        for one, other in (("1", "2"), ("1", "9"), ("9", "1"))
    )
    text = document(linked("1", 0, behind="2"), linked("2", 100, before="1", behind="9"))
    root = parse(write(tmp_path, text.replace("</OpenDRIVE>", f'<junction id="5">{ways}</junction></OpenDRIVE>')))
    assert simplify(root) == ["links to roads that are not on the map, left out: 3"]
    assert [link.get("elementId") for link in root.iterfind("road/link/")] == ["2", "1"]
    assert len(root.findall("junction/connection")) == 1
