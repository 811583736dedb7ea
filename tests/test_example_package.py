"""A package of somebody else adds one part of each kind, is built and installed, and runs."""

import csv
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from gpsec.testing import (
    check_attack,
    check_detector,
    check_dynamics,
    check_profile,
    check_reaction,
    check_response,
)

NAMES = {
    "attacks": "sway",
    "detectors": "energy",
    "responses": "coast",
    "profiles": "taxi",
    "reactions": "linger",
    "dynamics": "glide",
}
SCENARIO = """
sumocfg = "{config}"
duration_s = 40.0
[fleet]
profile = "taxi"
settle_s = 2.0
[detection]
detectors = ["energy"]
[[defences]]
detector = "energy"
response = "coast"
[[plans]]
attack = "sway"
amplitude_m = 4.0
share = 1.0
"""


@pytest.fixture(scope="module")
def site(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that the package is installed in."""
    built = tmp_path_factory.mktemp("built")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(built)]
    subprocess.run(build, cwd=repository / "tests" / "example_package", check=True, capture_output=True)
    installed = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(next(built.glob("*.whl"))) as wheel:
        wheel.extractall(installed)
    return installed


@pytest.fixture(scope="module")
def gpsec(site: Path, repository: Path):
    paths = os.pathsep.join([str(site), str(repository)])

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "gpsec", *arguments]
        environment = {**os.environ, "PYTHONPATH": paths}
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)

    return run


def test_its_parts_are_listed_and_help_who_mistypes(gpsec):
    for kind, name in NAMES.items():
        assert f"\n{name} " in gpsec("list", kind).stdout
    said = gpsec("check", "slow_curve", "--set", 'plans=[{attack="swya"}]')
    assert said.returncode == 2
    assert "did you mean 'sway'" in said.stderr


def test_all_of_them_run_together(gpsec, repository, tmp_path):
    (tmp_path / "s").mkdir()
    config = repository / "scenarios" / "slow_curve" / "slow_curve.sumocfg"
    (tmp_path / "s" / "gpsec.toml").write_text(SCENARIO.format(config=config))
    out = tmp_path / "run"
    ran = gpsec("run", str(tmp_path / "s"), "--out", str(out))
    assert ran.returncode == 0, ran.stderr
    rows = (out / "detection.csv").read_text().splitlines()
    assert any(",taxi,sway,energy," in row for row in rows)
    assert "energy+coast" in (out / "safety.csv").read_text()
    assert "energy+coast" in (out / "report.html").read_text()
    stated = json.loads((out / "manifest.json").read_text())["scenarios"][0]
    assert stated["configuration"]["parts"] == []
    again = gpsec("run", str(tmp_path / "s"), "--out", str(out), "--resume")
    assert again.returncode == 0
    assert "running" not in again.stderr


def test_its_reaction_and_its_dynamics_drive_in_closed_loop(gpsec, repository, tmp_path):
    (tmp_path / "s").mkdir()
    config = repository / "scenarios" / "slow_curve" / "slow_curve.sumocfg"
    (tmp_path / "s" / "gpsec.toml").write_text(SCENARIO.format(config=config))
    out = tmp_path / "run"
    asked = '[{plan="sway",defence="energy+coast",on_alarm="linger"}]'
    sets = ("--set", f"closed_loop.worlds={asked}", "--set", "closed_loop.dynamics=glide", "--seeds", "3")
    ran = gpsec("run", str(tmp_path / "s"), "--closed-loop", *sets, "--duration", "25", "--out", str(out))
    assert ran.returncode == 0, ran.stderr
    with (out / "worlds.csv").open(encoding="utf-8") as file:
        benign, attacked = csv.DictReader(file)
    assert (benign["on_alarm"], attacked["on_alarm"]) == ("linger", "linger")
    assert int(attacked["handovers"]) > 0  # to the lane, without braking: after the alarm
    assert float(attacked["mean_speed_mps"]) < float(benign["mean_speed_mps"])


FINGERPRINT = """
from gpsec.pipeline.fingerprint import fingerprint
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set

sets = ['plans=[{attack="sway"}]', 'closed_loop.worlds=[{on_alarm="linger"}]']
print(fingerprint(load_scenario("slow_curve", [parse_set(text) for text in sets])))
"""


@pytest.mark.parametrize("part", ["sway", "linger"])
def test_an_edit_of_the_package_is_another_run(site, repository, part):
    def told() -> str:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), str(repository)])}
        command = [sys.executable, "-c", FINGERPRINT]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout

    before = told()
    file = site / "gpsec_example" / f"{part}.py"
    text = file.read_text()
    file.write_text(text + "\n# edited\n")
    try:
        assert told() != before
    finally:
        file.write_text(text)
    assert told() == before


def test_its_parts_keep_the_contracts(site, monkeypatch):
    monkeypatch.syspath_prepend(str(site))
    from gpsec_example.coast import Coast
    from gpsec_example.energy import Energy
    from gpsec_example.glide import Glide
    from gpsec_example.linger import Linger
    from gpsec_example.sway import Sway
    from gpsec_example.taxi import TAXI

    check_attack(Sway, period_s=2.0)
    check_detector(lambda profiles: Energy(), threshold=Energy.fixed_threshold)
    check_response(Coast)
    check_profile(TAXI)
    check_reaction(Linger)
    check_dynamics(Glide)
