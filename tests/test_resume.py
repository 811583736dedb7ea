"""A run that was killed leaves whole files only, and goes on to the same bytes."""

import json
import os
import random
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.console import aftermath
from gpsec.outcomes.digests import table_digests
from gpsec.outcomes.tables import TABLES
from gpsec.running.batch import _missing
from gpsec.running.workers import has_result
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set

ROOT = Path(__file__).parents[1]
NAMES = ("one", "two", "three", "four")

SCRIPT = """
import json, sys, time
sys.path[:0] = [{root!r}, {tests!r}]
from gpsec.pipeline.fingerprint import fingerprint
from gpsec.outcomes.digests import table_digests
from gpsec.outcomes.tables import TABLES
from test_resume import NAMES
from tests.batches import main_with

def run(scenario, folder, report):
    for table in TABLES:
        with open(folder / f"{{table}}.csv", "w") as file:
            file.write("scenario,row\\n")
            for row in range(20):
                file.write(f"{{scenario.name}},{{row}}\\n")
                file.flush()
                time.sleep(0.001)
    stated = {{"scenario": scenario.name, "fingerprint": fingerprint(scenario), "tables": table_digests(folder)}}
    (folder / "manifest.json").write_text(json.dumps(stated))

if __name__ == "__main__":
    sys.exit(main_with(run, ["run", *NAMES, "--out", "all", *sys.argv[1:]]))
"""


def make_scenarios(here: Path) -> None:
    config = ROOT / "scenarios" / "slow_curve" / "slow_curve.sumocfg"
    for name in NAMES:
        (here / name).mkdir()
        (here / name / "gpsec.toml").write_text(f'sumocfg = "{config}"\n')
    (here / "script.py").write_text(textwrap.dedent(SCRIPT).format(root=str(ROOT), tests=str(Path(__file__).parent)))


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_killed_at_any_moment(tmp_path: Path) -> None:
    whole_folder, killed_folder = tmp_path / "whole", tmp_path / "killed"
    for folder in (whole_folder, killed_folder):
        folder.mkdir()
        make_scenarios(folder)
    command = [sys.executable, "script.py", "--jobs", "2"]
    began = time.monotonic()
    subprocess.run(command, cwd=whole_folder, check=True, capture_output=True)
    whole_s = time.monotonic() - began
    expected = content(whole_folder / "all")
    draw = random.Random(2026)
    kills, longest_s = 0, whole_s
    for attempt in range(80):
        if kills == 20:
            break
        # Every other time from the beginning, so that late moments come about as well as early ones.
        options = ["--resume"] if attempt % 2 else ["--overwrite"]
        process = subprocess.Popen(
            [*command, *options], cwd=killed_folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            process.wait(timeout=draw.uniform(0.2, 1.0) * longest_s)
            longest_s *= 0.9  # the machine has less to do than it had
        except subprocess.TimeoutExpired:
            os.kill(process.pid, signal.SIGKILL)
            process.wait()
            kills += 1
        published = killed_folder / "all"
        if (published / "manifest.json").exists():
            assert content(published) == expected
    assert kills == 20
    subprocess.run([*command, "--resume"], cwd=killed_folder, check=True, capture_output=True)
    assert content(killed_folder / "all") == expected
    assert not (killed_folder / ".all.partial").exists()


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    make_scenarios(tmp_path)
    return tmp_path


def held(folder: Path, *fingerprints: str) -> None:
    folder.mkdir()
    for name in TABLES:
        (folder / f"{name}.csv").write_text("scenario\n")
    scenarios = [{"scenario": name, "fingerprint": each} for name, each in zip(NAMES, fingerprints, strict=False)]
    (folder / "manifest.json").write_text(json.dumps({"scenarios": scenarios, "tables": table_digests(folder)}))


def test_a_whole_run_is_not_run_again(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gpsec.pipeline.fingerprint import fingerprint

    scenarios = [load_scenario(name) for name in NAMES]
    assert len({fingerprint(scenario) for scenario in scenarios}) == len(NAMES)
    held(here / "all", *(fingerprint(scenario) for scenario in scenarios))
    held(here / "part", fingerprint(scenarios[0]))
    assert _missing({here / "all": scenarios}) == {}
    assert _missing({here / "part": scenarios, here / "none": scenarios[:1]}) == {
        here / "part": scenarios,
        here / "none": scenarios[:1],
    }
    shown: list[Path] = []
    monkeypatch.setattr(aftermath, "show_findings", lambda folder, all_: shown.append(folder))
    monkeypatch.setattr(aftermath, "_report", lambda folder, messages: None)
    assert cli.main(["run", *NAMES, "--out", "all", "--resume"]) == 0
    assert shown == [here / "all"]


@pytest.mark.parametrize("spoil", [Path.unlink, lambda path: path.write_text("scenario\nby hand\n")])
def test_a_run_whose_tables_are_not_what_was_written_is_run_again(
    here: Path, spoil: Callable[[Path], object], capsys: pytest.CaptureFixture[str]
) -> None:
    from gpsec.pipeline.fingerprint import fingerprint

    scenarios = [load_scenario(name) for name in NAMES]
    folder = here / "all"
    held(folder, *(fingerprint(scenario) for scenario in scenarios))
    assert cli.main(["verify", "all"]) == 0
    assert _missing({folder: scenarios}) == {}
    capsys.readouterr()
    spoil(folder / "events.csv")
    assert cli.main(["verify", "all"]) == 1
    printed = capsys.readouterr().out.splitlines()
    state = "changed" if (folder / "events.csv").exists() else "missing"
    assert sorted(printed) == sorted(f"{state if name == 'events' else 'whole':<8} all/{name}.csv" for name in TABLES)
    assert cli.main(["verify", "nowhere", "all"]) == 2  # the others are looked at all the same
    assert capsys.readouterr().out.splitlines() == printed
    assert _missing({folder: scenarios}) == {folder: scenarios}


def test_another_run_is_not_resumed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    held(here / "all", "of something else")
    assert cli.main(["run", "one", "--out", "all", "--resume"]) == 2
    assert "all: holds another run, or one whose input has changed" in capsys.readouterr().err
    (here / "all" / "manifest.json").write_text("[")
    assert cli.main(["run", "one", "--out", "all", "--resume"]) == 2
    assert "manifest.json: expected the manifest of a run" in capsys.readouterr().err


def test_what_changes_tables_changes_the_fingerprint(here: Path) -> None:
    from gpsec.pipeline.fingerprint import fingerprint

    def of(*changes: str) -> str:
        return fingerprint(load_scenario("one", [parse_set(change) for change in changes]))

    assert of("threads=2") == of()
    assert of("seed=2") != of()
    (here / "models").mkdir()
    (here / "models" / "thresholds.json").write_text("{}")
    own = of("detection.models=models")
    (here / "models").rename(here / "moved")
    assert of("detection.models=moved") == own != of()
    (here / "moved" / "thresholds.json").write_text("{ }")
    assert of("detection.models=moved") != own
    assert of("detection.rates=['0.1/h', '1e-4/sample']") != of()
    (here / "one" / "gpsec.toml").write_text(f'sumocfg = "{ROOT}/scenarios/town/town.sumocfg"\n')
    town = of()
    (here / "one" / "gpsec.toml").write_text(f'sumocfg = "{ROOT}/scenarios/slow_curve/slow_curve.sumocfg"\n')
    assert of() != town


def test_an_included_file_and_the_installed_libraries_are_part_of_the_fingerprint(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gpsec.pipeline import fingerprint as module

    net = ROOT / "sumo_nets" / "slow_curve" / "slow_curve.net.xml"
    (here / "one" / "gpsec.toml").unlink()
    (here / "one" / "one.sumocfg").write_text(
        f'<configuration><net-file value="{net}"/><additional-files value="all.add.xml"/></configuration>'
    )
    (here / "one" / "all.add.xml").write_text('<additional><include href="more.add.xml"/></additional>')
    (here / "one" / "more.add.xml").write_text('<additional><include href="last.add.xml"/></additional>')
    seen = [module.fingerprint(load_scenario("one"))]
    for content in ("<additional/>", '<additional><poi id="p" x="0" y="0"/></additional>'):
        (here / "one" / "last.add.xml").write_text(content)
        seen.append(module.fingerprint(load_scenario("one")))
    for package in ("eclipse-sumo", "scipy", "pyarrow", "torch", "scikit-learn", "numba", "numpy"):
        with monkeypatch.context() as patch:
            patch.setattr(module, "version", lambda name, other=package: "0" if name == other else version(name))
            seen.append(module.fingerprint(load_scenario("one")))
    monkeypatch.setattr("platform.python_version", lambda: "3.0")
    seen.append(module.fingerprint(load_scenario("one")))
    assert len(set(seen)) == len(seen)


def test_a_scenario_of_a_killed_run_counts_only_with_all_its_tables(here: Path) -> None:
    from gpsec.pipeline.fingerprint import fingerprint

    scenario, folder = load_scenario("one"), here / "work"
    held(folder, fingerprint(scenario))
    stated = {"scenario": "one", "fingerprint": fingerprint(scenario), "tables": table_digests(folder)}
    (folder / "manifest.json").write_text(json.dumps(stated))
    assert has_result(folder, scenario)
    (folder / "places.csv").write_text("scenario\nby hand\n")
    assert not has_result(folder, scenario)
