"""One SUMO for everything: the one that SUMO_HOME names where it is of the tested version, else the installed one."""

import re
from importlib.metadata import version
from pathlib import Path

import pytest
import sumo

import gpsec
from gpsec.scenario.paths import expand, portable
from gpsec.sumo.home import environment, expand_variables, program, sumo_home
from gpsec.sumo.tools import run_program, run_tool
from gpsec.traffic.config import read_config

INSTALLED = Path(sumo.SUMO_HOME)


def another(folder: Path, stated: str) -> Path:
    """Return a SUMO that only says its version and where it thinks that it is."""
    (folder / "bin").mkdir(parents=True)
    (folder / "tools").mkdir()
    for name in ("sumo", "netconvert"):
        file = folder / "bin" / name
        file.write_text(f'#!/bin/sh\necho "Eclipse SUMO {name} Version {stated}"\necho "$SUMO_HOME"\n')
        file.chmod(0o755)
    (folder / "tools" / "tool.py").write_text("import os; print(os.environ['SUMO_HOME'])")
    return folder


def test_another_sumo_of_the_same_version_is_used_for_everything(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = another(tmp_path / "own", version("libsumo"))
    monkeypatch.setenv("SUMO_HOME", str(home))
    assert sumo_home() == home
    assert run_program("netconvert", ["--version"], tmp_path).stdout.splitlines()[1] == str(home)
    assert run_tool("tool.py", [], tmp_path).stdout.strip() == str(home)
    assert expand("$SUMO_HOME/tools/a.sumocfg", tmp_path) == home / "tools" / "a.sumocfg"
    assert portable(home / "tools" / "a.sumocfg") == "$SUMO_HOME/tools/a.sumocfg"


@pytest.mark.parametrize("stated", ["1.2.0", "11.28.0", "1.280.0", "", None])
def test_any_other_one_is_used_for_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stated: str | None) -> None:
    home = tmp_path / "nowhere" if stated is None else another(tmp_path / "own", stated)
    monkeypatch.setenv("SUMO_HOME", str(home))
    assert sumo_home() == INSTALLED
    assert program("netconvert").parent == INSTALLED / "bin"
    assert environment()["SUMO_HOME"] == str(INSTALLED)
    assert expand("$SUMO_HOME/tools/a.sumocfg", tmp_path) == (INSTALLED / "tools" / "a.sumocfg").resolve()
    config = tmp_path / "a.sumocfg"
    config.write_text('<configuration><net-file value="${SUMO_HOME}/a.net.xml"/></configuration>')
    assert read_config(config).paths("net-file") == [INSTALLED / "a.net.xml"]


def test_variables_are_expanded_as_sumo_does_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TOWN", "berlin")
    monkeypatch.delenv("NOBODY", raising=False)
    monkeypatch.delenv("PID", raising=False)
    assert expand_variables("${TOWN}/$TOWN.xml $NOBODY ${NOBODY}${PID} 5$") == "berlin/$TOWN.xml $NOBODY ${PID} 5$"


def test_no_other_module_decides_which_sumo_it_is() -> None:
    asks = re.compile(r"sumo\.SUMO_HOME|environ(?:\.get)?[\[(]\"SUMO_HOME\"[\])](?! =)|\bimport sumo\b")
    root = Path(gpsec.__file__).parent
    found = {path.relative_to(root).as_posix() for path in root.rglob("*.py") if asks.search(path.read_text())}
    assert found == {"sumo/home.py"}
