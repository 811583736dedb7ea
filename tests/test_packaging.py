"""A wheel has all that it needs anywhere: scenarios, their nets, models, and what the pages are made of."""

import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

from gpsec.core import shipped
from gpsec.core.errors import GpsecError
from gpsec.scenario.paths import expand, find, portable, scenarios_in


@pytest.fixture(scope="module")
def wheel(repository, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=repository, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def elsewhere(wheel, tmp_path_factory):
    """A call of Python with the wheel in the place of this checkout, in a folder of its own."""
    folder = tmp_path_factory.mktemp("elsewhere")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    paths = os.pathsep.join([str(folder / "site"), sysconfig.get_path("purelib")])
    (folder / "here").mkdir()

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        # -S: neither this environment's link to the checkout nor anything else that it adds.
        command = [sys.executable, "-S", "-m", "gpsec", *arguments]
        environment = {**os.environ, "PYTHONPATH": paths}
        return subprocess.run(
            command, cwd=folder / "here", env=environment, capture_output=True, text=True, check=False
        )

    return run


def test_the_wheel_has_every_scenario_and_net_as_they_are_here_and_no_code_of_the_builders(wheel, repository):
    with zipfile.ZipFile(wheel) as archive:
        packed = {name: archive.read(name) for name in archive.namelist()}
    for top in ("scenarios", "sumo_nets"):
        for path in (repository / top).glob("*/*"):
            if path.suffix in {".xml", ".toml", ".sumocfg", ".netecfg", ".xodr"}:
                assert packed[f"gpsec/data/{path.relative_to(repository)}"] == path.read_bytes()
    assert not [name for name in packed if name.startswith("gpsec/data") and name.endswith(".py")]
    for needed in (
        "gpsec/data/results/reference/leaderboard.csv",
        "gpsec/py.typed",
        "gpsec/models/thresholds.json",
        "gpsec/models/carla-tracked.npz",
    ):
        assert needed in packed
    assert {Path(name).name for name in packed if name.startswith("gpsec/report/assets/")} == {
        path.name for path in (repository / "gpsec" / "report" / "assets").iterdir()
    }


def test_an_installed_gpsec_lists_checks_and_runs_its_scenarios_by_name(elsewhere, tmp_path):
    listed = elsewhere("list", "scenarios")
    assert [line.split()[0] for line in listed.stdout.splitlines()] == [
        path.name for path in scenarios_in(shipped.scenarios())
    ]
    assert "site/gpsec/data/scenarios" in listed.stdout
    ran = elsewhere("run", "slow_curve", "--duration", "5", "--out", str(tmp_path / "run"))
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "run" / "report.html").is_file()
    assert (
        '"sumocfg": "$GPSEC/scenarios/slow_curve/slow_curve.sumocfg"'
        in (tmp_path / "run" / "manifest.json").read_text()
    )
    wrong = elsewhere("run", "slow_curv")
    assert wrong.returncode == 2
    assert "did you mean 'slow_curve'" in wrong.stderr


def test_an_installed_gpsec_reports_on_a_run(elsewhere, tmp_path):
    assert elsewhere("run", "slow_curve", "--duration", "5", "--no-report", "--out", str(tmp_path)).returncode == 0
    made = elsewhere("report", str(tmp_path))
    assert made.returncode == 0, made.stderr
    assert (tmp_path / "report.html").is_file()


@pytest.mark.slow
def test_an_installed_gpsec_trains(elsewhere, tmp_path):
    only = ("--detector", "chi_square", "--profile", "dsd", "--networks", "suburb")
    trained = elsewhere("train", *only, "--out", str(tmp_path))
    assert trained.returncode == 0, trained.stderr
    assert "chi_square" in (tmp_path / "thresholds.json").read_text(encoding="utf-8")
    run = ("run", "slow_curve", "--duration", "5", "--no-report", "--set", f"detection.models={tmp_path}")
    ran = elsewhere(*run, "--set", "fleet.profile=dsd", "--out", str(tmp_path / "run"))
    assert ran.returncode in (0, 2), ran.stderr


@pytest.mark.slow
def test_an_installed_gpsec_makes_the_tables_of_the_paper(elsewhere, tmp_path):
    made = elsewhere("paper", "--quick", "--out", str(tmp_path))
    assert made.returncode == 0, made.stderr
    assert list(tmp_path.glob("*.csv"))


def test_a_path_comes_before_the_name_of_a_scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert find("town").folder == shipped.scenarios() / "town"
    (tmp_path / "town").mkdir()
    (tmp_path / "town" / "gpsec.toml").touch()
    assert find("town").folder == Path("town")
    with pytest.raises(GpsecError, match="no such file"):
        find("./highway")


def test_a_path_of_gpsec_means_the_same_on_another_machine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    config = shipped.scenarios() / "town" / "town.sumocfg"
    assert portable(config) == "$GPSEC/scenarios/town/town.sumocfg"
    assert expand(portable(config), tmp_path) == config


def test_shell_completion_is_offered(monkeypatch, elsewhere):
    assert "--install-completion" in elsewhere("--help").stdout


def _installed() -> list[str]:
    """Return the other versions of Python that are supported, where this machine has them."""
    others = [f"python3.{minor}" for minor in (11, 12, 13) if minor != sys.version_info.minor]
    found = [name for name in others if shutil.which(name)]
    return [name for name in found if not subprocess.run([name, "-c", "import venv"], capture_output=True).returncode]


@pytest.mark.slow
@pytest.mark.parametrize("python", _installed())
def test_another_python_gives_the_same_bytes(python, wheel, repository, elsewhere, tmp_path):
    subprocess.run([python, "-m", "venv", tmp_path / "venv"], check=True)
    install = [tmp_path / "venv" / "bin" / "pip", "install", "--quiet", "--constraint", repository / "constraints.txt"]
    subprocess.run([*install, wheel], check=True)
    run = ["run", "sharp_turns", "--duration", "60", "--no-report", "--out"]
    assert elsewhere(*run, str(tmp_path / "ours")).returncode == 0
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    theirs = [tmp_path / "venv" / "bin" / "gpsec", *run, tmp_path / "theirs"]
    subprocess.run(theirs, cwd=tmp_path, env=clean, check=True, capture_output=True)
    tables = sorted(path.name for path in (tmp_path / "ours").glob("*.csv"))
    assert len(tables) > 5
    for name in tables:
        assert (tmp_path / "ours" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes(), name
