"""The schema of `gpsec.toml` and its documentation, held against the models."""

import importlib.util
import json
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from jsonschema import Draft7Validator
from pydantic import BaseModel

from gpsec.attacks.plans import PlanConfig
from gpsec.attacks.registry import ATTACKS
from gpsec.core.errors import GpsecError
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.scenario.schema import SECTIONS, descriptions, json_schema, section_of

ROOT = Path(__file__).parents[2]
SCHEMA = json_schema()


@pytest.fixture(scope="module")
def generate() -> ModuleType:
    """The script in docs, which is no package."""
    spec = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def model(section: str) -> Any:
    lists: dict[str, type[BaseModel]] = {"": Scenario, "defences": Defence, "plans": PlanConfig}
    return lists.get(section) or Scenario.model_fields[section].annotation


def faults(toml: str) -> list[str]:
    return [error.message for error in Draft7Validator(SCHEMA).iter_errors(tomllib.loads(toml))]


def test_the_documentation_is_what_the_models_say(generate: ModuleType) -> None:
    page = (ROOT / "docs" / "scenario.md").read_text("utf-8")
    assert generate.scenario_page(page) == page, "python docs/generate.py writes it anew"
    assert (ROOT / "docs" / "gpsec.schema.json").read_text("utf-8") == generate.schema_text()


@pytest.mark.parametrize("section", ["", *SECTIONS])
def test_every_key_of_the_models_is_there_with_what_it_means(section: str) -> None:
    part = section_of(SCHEMA, section)
    assert list(part["properties"]) == list(model(section).model_fields)
    assert part["additionalProperties"] is False
    plain = [key for key in part["properties"] if key not in SECTIONS]
    assert all(len(part["properties"][key]["description"]) > 3 for key in plain), plain
    if section:
        page = (ROOT / "docs" / "scenario.md").read_text("utf-8")
        assert f"<!-- keys: {section} -->" in page


@pytest.mark.parametrize("name", ATTACKS)
def test_a_plan_has_the_keys_of_its_attack_alone(name: str) -> None:
    [plan] = [each for each in SCHEMA["properties"]["plans"]["items"]["oneOf"] if each["title"] == name]
    assert set(plan["properties"]) == {*PlanConfig.model_fields, *ATTACKS[name].model_fields}
    assert faults(f"[[plans]]\nattack = '{name}'") == []
    defaults = {key: value["default"] for key, value in plan["properties"].items() if "default" in value}
    for key, field in ATTACKS[name].model_fields.items():
        assert defaults[key] == json.loads(json.dumps(field.get_default()))


def test_there_are_no_references_which_some_editors_do_not_follow() -> None:
    Draft7Validator.check_schema(SCHEMA)
    assert "$ref" not in json.dumps(SCHEMA)
    assert "null" not in json.dumps(SCHEMA)


@pytest.mark.parametrize("toml", sorted((ROOT / "scenarios").glob("*/gpsec.toml")), ids=lambda path: path.parent.name)
def test_the_schema_takes_the_scenarios_that_there_are(toml: Path) -> None:
    assert faults(toml.read_text("utf-8")) == []


ALIKE = [
    ("", True),
    ("seed = 5\nduration_s = 60\nname = 'a-b.c'", True),
    ("[fleet]\nprofile = 'dsd'", True),
    ("[fleet]\nprofile = { dsd = 0.5, carla = 0.5 }", True),
    ("[[plans]]\nattack = 'drift'\nstart_after_s = [0, 5]\nvehicles = ['a.*']\nrate_mps = 0.2", True),
    ("[[defences]]\ndetector = 'lstm_glr'\nresponse = 'ukf'", True),
    ("sed = 5", False),
    ("seed = -1", False),
    ("seed = 1.5", False),
    ("name = 'a b'", False),
    ("duration_s = 0", False),
    ("engine = 'fast'", False),
    ("[fleet]\nprofile = 'carlo'", False),
    ("[fleet]\nprofile = { dsd = 0.0, carla = 1.0 }", False),
    ("[fleet]\nequipped_share = 0", False),
    ("[traffic]\nstep_s = 0.5", False),
    ("[detection]\ndetectors = ['lstm_glr', 'lstm_glr']", False),
    ("[detection]\nrates = ['2/h']", False),
    ("[detection]\nrates = []", False),
    ("[detection]\nrates = ['1/h', '1/h']", False),
    ("[[defences]]\ndetector = 'lstm_glr'", False),
    ("[[plans]]\nshare = 0.5", False),
    ("[[plans]]\nattack = 'drift'\nbias_m = 2", False),
    ("[[plans]]\nattack = 'drift'\nrate_mps = 'fast'", False),
    ("[[plans]]\nattack = 'drift'\nduration_s = [1, 2, 3]", False),
]


@pytest.mark.parametrize(("toml", "good"), ALIKE)
def test_the_schema_and_the_models_take_and_refuse_the_same(tmp_path: Path, toml: str, good: bool) -> None:
    (tmp_path / "a.sumocfg").write_text("<configuration/>")
    (tmp_path / "gpsec.toml").write_text(toml)
    assert (faults(toml) == []) == good
    try:
        load_scenario(tmp_path)
    except GpsecError:
        assert not good
    else:
        assert good


def test_descriptions_may_stand_for_several_keys_and_go_over_several_lines() -> None:
    class Both(BaseModel):
        """First line.

        Attributes:
            a, b: of both of
                them, ``such``.
            c: alone.

        More.
        """

        a: int
        b: int
        c: int

    assert descriptions(Both) == {"a": "of both of them, `such`", "b": "of both of them, `such`", "c": "alone"}
