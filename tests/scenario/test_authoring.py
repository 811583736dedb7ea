"""The walk-through, held against what it talks of."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from gpsec.attacks.vehicle_plans import SPOOFER_HOLD_S, SPOOFER_REACH_M, plans_from_vehicles
from gpsec.attacks.zones import zone_keys
from gpsec.sensors.multipath import MULTIPATH_KEYS
from gpsec.traffic.vehicle_attacks import carried_attacks
from gpsec.traffic.vehicletypes import ROAD_CLASSES, TYPE_KEYS
from gpsec.types.drawn_zones import MULTIPATH_ZONE

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "authoring.md").read_text("utf-8")
LINKS = re.findall(r"\]\(([^)#]+)\)", PAGE)
EXAMPLES = re.findall(r"```xml\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("link", LINKS)
def test_what_it_points_to_is_there(link: str) -> None:
    assert (DOCS / link).is_file()


def test_there_are_four_pictures_and_no_others_lie_about() -> None:
    shown = {link.removeprefix("pictures/") for link in LINKS if link.endswith(".png")}
    assert len(shown) == 4
    assert {path.name for path in (DOCS / "pictures").glob("netedit-*.png")} == shown


def test_every_class_that_is_equipped_is_listed() -> None:
    [listed] = re.findall(r"Equipped are .*?the classes (.*?)\.\s", PAGE, re.DOTALL)
    assert set(re.findall(r"`(\w+)`", listed)) == ROAD_CLASSES


def test_every_parameter_that_is_named_is_one() -> None:
    known = {*zone_keys(), MULTIPATH_ZONE, *MULTIPATH_KEYS, *TYPE_KEYS, "gpsec.hold_s", "gpsec.plan"}
    named = set(re.findall(r"gpsec\.[a-z_]+", PAGE)) - {"gpsec.toml", "gpsec.schema"}
    assert named <= known
    assert f"The reach is {SPOOFER_REACH_M:g} m" in PAGE
    assert f"The hold is {SPOOFER_HOLD_S:g} s" in PAGE


def test_the_examples_are_plans(tmp_path: Path) -> None:
    file = tmp_path / "examples.rou.xml"
    file.write_text(f"<routes>{''.join(EXAMPLES)}</routes>")
    ElementTree.parse(file)
    plans = plans_from_vehicles(carried_attacks([file]))
    assert [(config.name, config.attack, config.vehicles) for config, _, _ in plans] == [
        ("spoofer_van", "stealth", ()),
        ("bus_line", "drift", ("bus_line.*",)),
    ]
