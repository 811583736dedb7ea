"""The example in docs/adding-an-attack.md is an attack that works."""

import ast
import importlib.util
import os
import re
import shutil
import subprocess
import sys
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
def test_the_guide_is_followed_whole_in_a_fresh_clone(repository: Path, tmp_path: Path) -> None:
    clone = tmp_path / "clone"
    left_out = shutil.ignore_patterns(".*", "results", "build", "__pycache__")
    shutil.copytree(repository, clone, ignore=left_out)
    (clone / "gpsec" / "attacks" / "sway.py").write_text(block("python"), encoding="utf-8")
    insert(
        clone / "gpsec" / "attacks" / "registry.py",
        "from gpsec.attacks.two_stage",
        "from gpsec.attacks.sway import Sway",
    )
    insert(clone / "gpsec" / "attacks" / "registry.py", "    LaneAlias,", "    Sway,")
    row = re.search(r"AttackCase\(ATTACKS\[\"sway\"\], .*\),", GUIDE)
    assert row
    insert(clone / "tests" / "attacks" / "test_contract.py", "    AttackCase(", f"    {row[0]}")
    (clone / "mine.toml").write_text(
        f'sumocfg = "{clone / "scenarios" / "slow_curve" / "slow_curve.sumocfg"}"\nduration_s = 20.0\n{block("toml")}'
        "[fleet]\nsettle_s = 1.0\n[detection]\ndetectors = []\n[[defences]]\ndetector = 'never'\nresponse = 'none'\n",
        encoding="utf-8",
    )
    done = run_in(clone, "docs/generate.py")
    done += run_in(
        clone, "-m", "pytest", "-q", "-n", "0", "tests/attacks/test_contract.py", "tests/scenario/test_schema.py"
    )
    done += run_in(clone, "-m", "ruff", "check", "gpsec/attacks", "tests/attacks")
    done += run_in(clone, "-m", "ruff", "format", "--check", "gpsec/attacks", "tests/attacks")
    done += run_in(clone, "-m", "gpsec", "run", "mine.toml", "--out", "found", "--no-report")
    assert "sway" in (clone / "found" / "events.csv").read_text("utf-8"), done
    assert "\nsway " in run_in(clone, "-m", "gpsec", "list", "attacks")


def insert(file: Path, before: str, line: str) -> None:
    text = file.read_text("utf-8")
    file.write_text(text.replace(before, f"{line}\n{before}", 1), "utf-8")


def run_in(clone: Path, *arguments: str) -> str:
    environment = os.environ | {"PYTHONPATH": str(clone)}
    done = subprocess.run(
        [sys.executable, *arguments], cwd=clone, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{arguments}: {done.stdout}\n{done.stderr}"
    return done.stdout
