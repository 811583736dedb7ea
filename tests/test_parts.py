"""Parts from outside gpsec: chosen by the user, found in every process, and never run because a file says so."""

import json
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.attacks.base import Attack
from gpsec.attacks.registry import ATTACKS
from gpsec.core import registry, shipped
from gpsec.core.errors import GpsecError
from gpsec.core.registry import Registry, subclass_named
from gpsec.pipeline.fingerprint import fingerprint
from gpsec.running.results import load
from gpsec.scenario import Scenario, load_scenario, parts
from gpsec.scenario.outside import Outside
from gpsec.scenario.overrides import parse_set
from gpsec.sensors.registry import PROFILES

ZIGZAG = """
from typing import ClassVar

import numpy as np
from pydantic import Field

from gpsec.attacks.base import Attack, displace_left

RAN = True


class Zigzag(Attack):
    \"\"\"A bias that changes its side.\"\"\"

    name: ClassVar[str] = "{name}"
    bias_m: float = Field(1.5, ge=0.0, le=50.0)

    def spoof(self, victims, state):
        return displace_left(victims, self.bias_m * np.where(victims.elapsed_s // 4.0 % 2.0 == 0.0, 1.0, -1.0))
"""
PLAN = 'plans=[{{attack="{name}", share=1.0}}]'


@pytest.fixture(autouse=True)
def as_before(monkeypatch):
    """What a test loads stays for the life of a process; here it is gone after the test."""
    for held in parts.REGISTRIES:
        for of in ("_parts", "_modules"):
            monkeypatch.setattr(held, of, dict(getattr(held, of)))
    monkeypatch.setattr(parts, "_used", {})


@pytest.fixture
def mine(tmp_path):
    """A file with an attack, and its name."""
    path = tmp_path / "mine.py"
    path.write_text(ZIGZAG.format(name="zigzag"))
    return path, "zigzag"


def scenario_file(folder: Path, part: str, attack: str) -> Path:
    made = folder / "s"
    made.mkdir()
    config = shipped.scenarios() / "slow_curve" / "slow_curve.sumocfg"
    plan = f'[[plans]]\nattack = "{attack}"\nshare = 1.0\n'
    (made / "gpsec.toml").write_text(f'sumocfg = "{config}"\nparts = ["{part}"]\n{plan}')
    return made


def test_an_attack_of_a_file_runs_in_its_own_processes_and_is_told_by_its_name(mine, tmp_path, capfd):
    path, name = mine
    plan = PLAN.format(name=name)
    arguments = ["slow_curve", "--duration", "25", "--set", plan, "--part", f"{path}:Zigzag", "--tables"]
    assert cli.main(["run", *arguments, "--no-report", "--out", str(tmp_path / "run")]) == 0
    assert f"\n{name} (" in capfd.readouterr().out
    assert name in (tmp_path / "run" / "events.csv").read_text()
    stated = json.loads((tmp_path / "run" / "manifest.json").read_text())["scenarios"][0]
    assert stated["configuration"]["parts"] == [f"{path}:Zigzag"]


def test_a_run_with_a_part_is_simulated_again_only_where_its_code_is_allowed(mine, tmp_path, capfd, monkeypatch):
    path, name = mine
    arguments = ["slow_curve", "--duration", "25", "--set", PLAN.format(name=name), "--part", f"{path}:Zigzag"]
    run = tmp_path / "run"
    assert cli.main(["run", *arguments, "--no-report", "--log-vehicle", "nobody", "--out", str(run)]) == 0
    assert "no steps of nobody: no such vehicle in this run" in capfd.readouterr().err
    (run / "steps.parquet").unlink()
    monkeypatch.setattr(parts, "_used", {})  # as in another process
    assert cli.main(["report", str(run), "--again"]) == 2
    assert "--allow-code runs it" in capfd.readouterr().err
    assert (run / "report.html").is_file()
    assert cli.main(["report", str(run), "--again", "--allow-code"]) == 0
    vehicle = load(run).events["vehicle_id"].iloc[0]
    assert cli.main(["trace", str(run), vehicle, "--part", f"{path}:Zigzag"]) == 0


def test_a_listed_part_is_shown_and_helps_who_mistypes(mine, capsys):
    path, name = mine
    assert cli.main(["list", "attacks", "--part", f"{path}:Zigzag"]) == 0
    assert "zigzag         A bias that changes its side. (bias_m = 1.5)\n" in capsys.readouterr().out
    assert cli.main(["check", "slow_curve", "--set", PLAN.format(name=f"{name}x"), "--part", f"{path}:Zigzag"]) == 2
    assert f"did you mean '{name}'" in capsys.readouterr().err


def test_code_that_a_scenario_file_names_is_not_run_unless_that_is_asked_for(mine, tmp_path, capsys):
    path, name = mine
    folder = scenario_file(tmp_path, "../mine.py:Zigzag", name)
    assert cli.main(["check", str(folder)]) == 2
    said = capsys.readouterr().err
    assert "gpsec.toml: parts.0: '../mine.py:Zigzag' is code" in said
    assert "--allow-code" in said
    assert not [module for module in sys.modules.values() if getattr(module, "__file__", None) == str(path)]
    assert load_scenario(folder, outside=Outside(allow_code=True)).parts == (f"{path}:Zigzag",)
    assert parts.in_use(f"{path}:Zigzag")
    # Whose code runs already has been chosen.
    assert load_scenario(folder).plans[0].attack == name


def test_code_in_a_manifest_that_was_received_is_not_run(mine, tmp_path):
    path, name = mine
    told = load_scenario("slow_curve").model_dump(mode="json") | {"parts": [f"{path}:Zigzag"]}
    with pytest.raises(ValueError, match="is code"):
        Scenario.model_validate(told)
    assert not parts.in_use(f"{path}:Zigzag")
    assert name not in ATTACKS


def profile_text():
    """Return a sensor profile in TOML: that of `dsd` on another map."""
    text = ["map_spacing_m = 1.5"]  # its name is that of the file
    dsd = PROFILES["dsd"]
    text += [f"sources = {{ map_spacing_m = {json.dumps('measured')} }}"]
    for channel, values in dsd.channels().items():
        text.append(f"[{channel}]")
        text += [f"{key} = {value!r}" for key, value in values.figures().items()]
        text.append("[" + channel + ".sources]")
        text += [f"{key} = {json.dumps(source)}" for key, source in values.sources.items()]
    return "\n".join(text)


def test_a_scenario_with_parts_can_be_sent_as_json(mine, tmp_path, monkeypatch):
    path, name = mine
    profile = tmp_path / "car.toml"
    profile.write_text(profile_text())
    chosen = Outside((f"{path}:Zigzag", str(profile)))
    sets = [parse_set(PLAN.format(name=name)), parse_set("fleet.profile=car")]
    scenario = load_scenario("slow_curve", sets, chosen)
    text = scenario.model_dump_json()
    assert json.loads(text)["parts"] == [f"{path}:Zigzag", str(profile)]
    monkeypatch.chdir("/")
    assert Scenario.model_validate_json(text) == scenario
    # Another machine, where nobody has loaded them yet.
    monkeypatch.setattr(parts, "_used", {})
    with pytest.raises(ValueError, match="is code"):
        Scenario.model_validate_json(text)
    assert Scenario.model_validate_json(text, context={"allow_code": True}) == scenario


def test_a_profile_in_toml_is_no_code(tmp_path):
    (tmp_path / "mine.toml").write_text(profile_text())
    folder = tmp_path / "s"
    folder.mkdir()
    config = shipped.scenarios() / "slow_curve" / "slow_curve.sumocfg"
    (folder / "gpsec.toml").write_text(f'sumocfg = "{config}"\nparts = ["../mine.toml"]\n[fleet]\nprofile = "mine"\n')
    scenario = load_scenario(folder)
    assert scenario.fleet.profile == {"mine": 1.0}
    assert PROFILES["mine"].gnss == PROFILES["dsd"].gnss
    assert PROFILES["mine"].map_spacing_m == 1.5
    broken = tmp_path / "broken.toml"
    broken.write_text(profile_text().replace("white_m = 0.008", "white_m = -1.0"))
    with pytest.raises(GpsecError, match=r"broken\.toml: gnss\.white_m: .*greater than or equal to 0"):
        parts.use([str(broken)])
    broken.write_text(profile_text().partition("[gyro]")[0])
    with pytest.raises(GpsecError, match=r"broken\.toml: gyro is missing"):
        parts.use([str(broken)])


def test_what_cannot_be_loaded_is_said_in_a_sentence(tmp_path):
    (tmp_path / "bad.py").write_text("import nowhere_at_all\n")
    (tmp_path / "other.py").write_text("class Other: ...\nclass Nameless: name = 3\n")
    for reference, words in (
        (f"{tmp_path}/bad.py:X", "cannot be imported: ModuleNotFoundError"),
        (f"{tmp_path}/gone.py:X", "cannot be read: No such file"),
        (f"{tmp_path}/other.py:Y", "has no 'Y'"),
        (f"{tmp_path}/other.py:Other", "expected one of attack, detector, response, sensor profile"),
        (f"{tmp_path}/other.py:Nameless", "expected one of"),
        ("nowhere_at_all:X", "cannot be imported: ModuleNotFoundError"),
        ("no reference", "expected FILE.py:Name"),
    ):
        with pytest.raises(GpsecError, match=words):
            parts.use([parts.relocate(reference, str)])


def test_another_part_of_a_name_that_is_taken_is_refused(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(ZIGZAG.format(name="drift"))
    with pytest.raises(GpsecError, match="'drift' is that of another attack"):
        parts.use([f"{path}:Zigzag"])


def test_the_fingerprint_counts_the_content_of_a_part(mine):
    path, name = mine
    chosen = Outside((f"{path}:Zigzag",))
    scenario = load_scenario("slow_curve", [parse_set(PLAN.format(name=name))], chosen)
    before = fingerprint(scenario)
    assert fingerprint(scenario) == before
    path.write_text(path.read_text() + "\n# edited\n")
    assert fingerprint(scenario) != before


class Installed(Attack):
    """Comes with an installed package."""

    name = "installed"


class NotNamed: ...


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("tests.test_parts:Installed", ""),
        ("tests.test_parts:NotNamed", "is no attack with a name"),
        ("tests.test_parts:Gone", "cannot be imported: AttributeError"),
    ],
)
def test_parts_of_installed_packages_are_found_when_they_are_asked_for(value, words, monkeypatch):
    entry = EntryPoint("installed", value, "gpsec.attacks")
    monkeypatch.setattr(registry, "entry_points", lambda group: [entry] if group == "gpsec.attacks" else [])
    made: Registry[type[Attack]] = Registry("attack", "gpsec.attacks", {"own": Attack}, subclass_named(Attack))
    assert made["own"] is Attack  # without a look at what is installed
    if words:
        with pytest.raises(GpsecError, match=words):
            list(made)
    else:
        assert list(made) == ["own", "installed"]
        assert made["installed"].__doc__ == Installed.__doc__
        assert made.module_of("installed") == "tests.test_parts"
        assert made.own == ("own",)
        assert made.module_of("own") == ""
