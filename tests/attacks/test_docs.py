"""The example in docs/adding-an-attack.md is an attack that works."""

import ast
import importlib.util
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from gpsec.attacks.plans import PlanConfig
from gpsec.attacks.registry import ATTACKS
from gpsec.attacks.zones import zone_keys
from gpsec.scenario import parts
from gpsec.testing import check_attack
from gpsec.testing.victims import displacement, make_victims
from tests.clones import Clone

GUIDE = (Path(__file__).parents[2] / "docs" / "adding-an-attack.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    match = re.search(rf"```{language}\n(.*?)```", GUIDE, re.DOTALL)
    assert match
    return match[1]


def _example(folder: Path) -> Path:
    file = folder / "sway.py"
    file.write_text(block("python"), encoding="utf-8")
    return file


@pytest.fixture(autouse=True)
def as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    for of in ("_parts", "_modules"):
        monkeypatch.setattr(ATTACKS, of, dict(getattr(ATTACKS, of)))
    monkeypatch.setattr(parts, "_used", {})


def test_the_example_sways(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("sway", _example(tmp_path))
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    attack = module.Sway(amplitude_m=2.0, period_s=8.0, side="as_given")
    moved = displacement(attack, make_victims(4, elapsed_s=np.array([0.0, 2.0, 4.0, 6.0])))
    assert moved == pytest.approx(np.array([[0, 0], [0, 2.0], [0, 0], [0, -2.0]]), abs=1e-12)


def test_the_plan_of_the_example_has_the_keys_of_a_plan() -> None:
    [table] = tomllib.loads(block("toml"))["plans"]
    assert set(table) - set(PlanConfig.model_fields) == {"amplitude_m"}


def test_the_names_that_parameters_must_not_have_are_listed() -> None:
    taken = {*PlanConfig.model_fields, *(key.removeprefix("gpsec.") for key in zone_keys()[:5])}
    assert all(f"`{name}`" in GUIDE for name in taken)


def test_the_row_of_the_example_keeps_the_contract_and_the_plan_runs(tmp_path: Path) -> None:
    row = re.search(r"AttackCase\(ATTACKS\[\"sway\"\], (\{.*?\})\)", GUIDE)
    assert row
    parts.use([f"{_example(tmp_path)}:Sway"])
    check_attack(ATTACKS["sway"], **ast.literal_eval(row[1]))
    [table] = tomllib.loads(block("toml"))["plans"]
    assert PlanConfig.model_validate(table).parameters.amplitude_m == 1.5


@pytest.mark.slow
def test_the_guide_is_followed_whole_in_a_copy_of_the_sources(tmp_path: Path) -> None:
    clone = Clone(tmp_path)
    (tmp_path / "gpsec" / "attacks" / "sway.py").write_text(block("python"), encoding="utf-8")
    row = re.search(r"AttackCase\(ATTACKS\[\"sway\"\], .*\),", GUIDE)
    assert row
    first = "from gpsec.attacks.two_stage"
    clone.edit(
        "gpsec/attacks/registry.py",
        (first, f"from gpsec.attacks.sway import Sway\n{first}"),
        ("    LaneAlias,", "    Sway,\n    LaneAlias,"),
    )
    clone.edit("tests/attacks/test_contract.py", ("    AttackCase(", f"    {row[0]}\n    AttackCase("))
    clone.run("docs/generate.py")
    clone.run("-m", "pytest", "-n", "0", "tests/attacks/test_contract.py", "tests/scenario/test_schema.py")
    clone.lint("gpsec/attacks", "tests/attacks")
    assert "sway" in (clone.evaluate(plans=block("toml")) / "events.csv").read_text("utf-8")
    assert "\nsway " in clone.run("-m", "gpsec", "list", "attacks")
