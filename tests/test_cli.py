import json
import os
import re
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path
from select import select

import pytest

from gpsec import cli
from gpsec.attacks.registry import ATTACKS
from gpsec.console import aftermath
from gpsec.core.errors import GpsecError
from gpsec.core.progress import Progress
from gpsec.outcomes.tables import TABLES
from gpsec.running import batch, impact
from gpsec.scenario import Scenario


def write_results(scenario: Scenario, folder: Path) -> None:
    for table in TABLES:
        (folder / f"{table}.csv").write_text(f"scenario,seed\n{scenario.name},{scenario.seed}\n")
    (folder / "manifest.json").write_text(json.dumps({"scenario": scenario.name}))


def fake_run(scenario: Scenario, folder: Path, report: Callable[[Progress], None]) -> None:
    """Stands in for the pipeline, in a process of its own."""
    report(Progress(scenario.name, 1.0, 2.0, vehicles=3, tracks=12, real_time_factor=20.0, note="step lowered"))
    print("SUMO's chatter")
    if scenario.name == "refused":
        raise GpsecError("refused.net.xml: expected drivable lanes, found none")
    if scenario.name == "faulty":
        raise ZeroDivisionError("by hand")
    if scenario.name == "killed":
        (folder / "detection.csv").write_text("half")
        os.kill(os.getpid(), signal.SIGKILL)
    write_results(scenario, folder)


def make(parent: Path, name: str, toml: str = "") -> Path:
    folder = parent / name
    folder.mkdir()
    (folder / f"{name}.sumocfg").write_text("<sumoConfiguration/>")
    (folder / "gpsec.toml").write_text(toml)
    return folder


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def faked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace pipeline, summary and report."""
    real = batch.run_scenarios
    monkeypatch.setattr(batch, "run_scenarios", lambda *args: real(*args[:4], fake_run))
    monkeypatch.setattr(aftermath, "show_findings", lambda folder, all_: print(f"tables of {folder.name}"))
    monkeypatch.setattr(impact, "write_impact", lambda folder: None)
    monkeypatch.setattr(aftermath, "_report", lambda folder, messages: None)


def never_run(*arguments: object) -> None:
    raise AssertionError("a bad input was run")


BAD_TOML = {
    "unknown key": ("sede = 1", ["unknown key 'sede'", "did you mean 'seed'?"]),
    "unknown section": ("[fleets]\nx = 1", ["unknown key 'fleets'", "did you mean 'fleet'?"]),
    "unknown key in fleet": ("[fleet]\nprofil = 'dsd'", ["unknown key 'profil' in fleet", "did you mean 'profile'?"]),
    "unknown key in traffic": ("[traffic]\nstep = 0.1", ["unknown key 'step' in traffic", "'step_s'"]),
    "unknown key in detection": ("[detection]\ndetector = []", ["unknown key 'detector' in detection"]),
    "unknown key in localization": ("[localization]\nholds_s = 1", ["unknown key 'holds_s'", "'hold_s'"]),
    "unknown key in outcomes": ("[outcomes]\nbootstraps = 1", ["unknown key 'bootstraps'", "'bootstrap'"]),
    "unknown key in a defence": (
        "[[defences]]\ndetector = 'lstm_glr'\nresponse = 'ukf'\nrespons = 'ukf'",
        ["unknown key 'respons' in defences.0", "did you mean 'response'?"],
    ),
    "unknown key in a plan": ("[[plans]]\nattack = 'drift'\nrate = 1.0", ["plans.0", "'rate'", "'rate_mps'"]),
    "text for a number": ("seed = 'one'", ["seed: expected a whole number, found 'one'"]),
    "fraction for a whole number": ("seed = 1.5", ["seed: expected a whole number, found 1.5"]),
    "truth value for a number": ("[fleet]\nsettle_s = true", ["fleet.settle_s: expected a number, found true"]),
    "number for a text": ("name = 3", ["name: expected a text, found 3"]),
    "number for a section": ("fleet = 3", ["fleet: expected a table, found 3"]),
    "table for a list": ("[plans]\nattack = 'drift'", ["plans: expected a list"]),
    "number in a list of tables": ("plans = [3]", ["plans.0: expected a table, found 3"]),
    "text for a list": (
        "[detection]\ndetectors = 'lstm_glr'",
        ["detection.detectors: expected a list, found 'lstm_glr'"],
    ),
    "infinite": ("duration_s = inf", ["duration_s: expected a finite number"]),
    "no duration": ("duration_s = 0", ["duration_s: expected more than 0, found 0"]),
    "share over 1": ("[fleet]\nequipped_share = 1.5", ["fleet.equipped_share: expected at most 1, found 1.5"]),
    "nobody equipped": ("[fleet]\nequipped_share = 0", ["fleet.equipped_share: expected more than 0, found 0"]),
    "plan's share over 1": ("[[plans]]\nattack = 'drift'\nshare = 1.5", ["plans.0", "share", "1.5"]),
    "step too long": ("[traffic]\nstep_s = 0.5", ["traffic.step_s: expected at most 0.2, found 0.5"]),
    "negative sublanes": ("[traffic]\nlateral_resolution_m = -1", ["traffic.lateral_resolution_m", "found -1"]),
    "text sublanes": ("[traffic]\nlateral_resolution_m = 'on'", ["traffic.lateral_resolution_m", "'on'"]),
    "unknown association": (
        "[fleet]\nassociation = 'nearst'",
        ["fleet.association", "'nearst'", "did you mean 'nearest'?"],
    ),
    "former name of association": (
        "[fleet]\nmatching = 'nearest'",
        ["fleet", "'matching' is now called 'association'"],
    ),
    "unknown engine": ("engine = 'batch'", ["engine", "'batch'", "did you mean 'batched'?"]),
    "unknown attack": ("[[plans]]\nattack = 'drft'", ["plans.0", "unknown attack 'drft'", "did you mean 'drift'?"]),
    "no attack": ("[[plans]]\nshare = 0.5", ["plans.0", "attack"]),
    "unknown detector": (
        "[detection]\ndetectors = ['cusm']",
        ["detection.detectors", "unknown detector 'cusm'", "did you mean 'cusum'?"],
    ),
    "detector twice": (
        "[detection]\ndetectors = ['cusum', 'cusum']",
        ["detection.detectors", "'cusum' is listed twice"],
    ),
    "no rate": (
        "[detection]\nrates = []",
        ["detection.rates", "expected at least one rate, such as '0.1/h', found none"],
    ),
    "doubled rate": ("[detection]\nrates = ['1/h', '0.1/h', '1/h']", ["detection.rates", "'1/h' is listed twice"]),
    "unknown rate": ("[detection]\nrates = ['1e-3/smple']", ["detection.rates", "1e-3/sample", "by the model"]),
    "former rate": (
        "[detection]\nfalse_alarm_rate = '0.1/h'",
        ["detection.false_alarm_rate", "`rate` of each defence"],
    ),
    "rate between": (
        "[[defences]]\ndetector = 'lstm'\nresponse = 'ukf'\nrate = '0.2/h'",
        ["defences.0.rate", "the nearest is '0.1/h'", "by the model of extreme values: 0.01/h, 1e-3/h"],
    ),
    "rate of told": (
        "[[defences]]\ndetector = 'told'\nresponse = 'ukf'\nrate = '1/h'",
        ["defences.0", "'told' has no calibrated threshold"],
    ),
    "former name of told": (
        "[[defences]]\ndetector = 'oracle'\nresponse = 'ukf'",
        ["defences.0.detector", "'oracle' is called 'told' now"],
    ),
    "unknown detector of a defence": (
        "[[defences]]\ndetector = 'lst'\nresponse = 'ukf'",
        ["defences.0.detector", "unknown detector 'lst'", "did you mean 'lstm'"],
    ),
    "unknown response": (
        "[[defences]]\ndetector = 'lstm_glr'\nresponse = 'ekf'",
        ["defences.0.response", "unknown response 'ekf'", "did you mean 'ukf'?"],
    ),
    "defence without response": ("[[defences]]\ndetector = 'lstm_glr'", ["defences.0.response: is missing"]),
    "defence twice": (
        "[[defences]]\ndetector='lstm_glr'\nresponse='ukf'\n[[defences]]\ndetector='lstm_glr'\nresponse='ukf'",
        ["defences", "'lstm_glr+ukf' is listed twice"],
    ),
    "defence without its detector": (
        "detection.detectors = ['cusum']\n[[defences]]\ndetector = 'lstm_glr'\nresponse = 'ukf'",
        ["defences", "'lstm_glr+ukf'", "detection.detectors"],
    ),
    "plan twice": ("[[plans]]\nattack='drift'\n[[plans]]\nattack='drift'", ["plans", "two plans are called 'drift'"]),
    "plan called none": ("[[plans]]\nattack='drift'\nname='none'", ["plans.0", "name", "'none'"]),
    "unknown profile": ("[fleet]\nprofile = 'carlo'", ["fleet.profile: unknown profile 'carlo'", "'carla'?"]),
    "shares do not add up": (
        "[fleet]\nprofile = {dsd = 0.5, carla = 0.3}",
        ["fleet.profile", "add up to 1, found 0.8"],
    ),
    "negative share": ("[fleet]\nprofile = {dsd = 1.5, carla = -0.5}", ["fleet.profile", "above 0 for 'carla'"]),
    "name with a slash": ("name = '../town'", ["name: expected letters", "'../town'"]),
    "sumocfg that is not there": ("sumocfg = 'twon.sumocfg'", ["sumocfg", "found no file", "twon.sumocfg"]),
    "sumocfg that is no text": ("sumocfg = 3", ["sumocfg: expected a path, found 3"]),
    "no TOML": ("seed = 1 2", ["not valid TOML", "line 1"]),
}


def sentence(capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one line that an error prints."""
    captured = capsys.readouterr()
    assert captured.err.startswith("gpsec: error: ")
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    return captured.err


@pytest.mark.parametrize("case", BAD_TOML)
def test_bad_toml(case: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    toml, fragments = BAD_TOML[case]
    make(here, "town", toml)
    monkeypatch.setattr(batch, "run_scenarios", never_run)
    assert cli.main(["run", "town"]) == 2
    said = sentence(capsys)
    assert all(fragment in said for fragment in ["town/gpsec.toml", *fragments]), said
    assert [path.name for path in here.iterdir()] == ["town"]


BAD_ARGUMENTS = {
    "no command": (["rnu"], ["no such command 'rnu'", "did you mean 'run'?"]),
    "unknown option": (["run", "town", "--sed", "1"], ["--sed", "did you mean", "--seed"]),
    "no scenario": (["run"], ["missing argument", "SCENARIO"]),
    "text for --seed": (["run", "town", "--seed", "x"], ["--seed", "integer"]),
    "negative --seed": (["run", "town", "--seed", "-1"], ["--seed -1: seed: expected at least 0"]),
    "--duration": (["run", "town", "--duration", "-5"], ["--duration -5.0: duration_s: expected more than 0"]),
    "--profile": (["run", "town", "--profile", "carlo"], ["--profile carlo: fleet.profile", "did you mean 'carla'?"]),
    "--engine": (["run", "town", "--engine", "refrence"], ["--engine refrence: engine", "did you mean 'reference'?"]),
    "--threads": (["run", "town", "--threads", "0"], ["--threads 0: threads: expected at least 1"]),
    "--jobs": (["run", "town", "--jobs", "0"], ["--jobs"]),
    "--set without value": (["run", "town", "--set", "seed"], ["--set seed: expected key=value"]),
    "--set of an unknown key": (["run", "town", "--set", "sed=1"], ["--set sed=1: unknown key 'sed'", "'seed'"]),
    "--set out of range": (["check", "town", "--set", "traffic.step_s=1"], ["--set traffic.step_s=1: traffic.step_s"]),
    "no such scenario": (["run", "tonw"], ["tonw: no such file or folder", "did you mean 'town'?"]),
    "bare name": (["run", "hill"], ["hill: no such file or folder; did you mean 'scenarios/hill'?"]),
    "other file": (["run", "notes.md"], ["notes.md: expected a scenario folder", "found a file '.md'"]),
    "empty folder": (["check", "empty"], ["empty: expected a gpsec.toml or one .sumocfg, found neither"]),
    "folder of scenarios": (["run", "scenarios"], ["found neither", "hill"]),
    "two sumocfgs": (["run", "two"], ["two: expected one .sumocfg, found a.sumocfg, b.sumocfg"]),
    "no sumocfg": (["run", "none"], ["none: expected one .sumocfg, found none"]),
    "same name twice": (["run", "town", "town/town.sumocfg"], ["'town' has the name of town"]),
    "out is a file": (["run", "town", "--out", "notes.md"], ["notes.md: expected an output folder, found a file"]),
    "out below a file": (["run", "town", "--out", "notes.md/x"], ["notes.md/x: no results can be written there"]),
    "out holds a run": (["run", "town", "--out", "done"], ["done: holds another run; give --overwrite"]),
    "out is the root": (["run", "town", "--out", "/"], ["/: expected an output folder, found the root"]),
    "out is no run": (["run", "town", "--out", "town", "--overwrite"], ["town: expected an empty or new folder"]),
    "default out holds a run": (["run", "scenarios/hill"], ["results/hill: holds another run"]),
    "unknown kind": (["list", "atacks"], ["KIND", "did you mean 'attacks'?"]),
    "no scenarios to list": (["list", "scenarios", "--dir", "empty"], ["empty: expected folders with a gpsec.toml"]),
}


@pytest.mark.parametrize("case", BAD_ARGUMENTS)
def test_bad_arguments(
    case: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments, fragments = BAD_ARGUMENTS[case]
    for name in ("scenarios", "empty", "none", "two", "done", "results"):
        (here / name).mkdir()
    make(here, "town")
    make(here / "scenarios", "hill")
    for path in ("two/a.sumocfg", "two/b.sumocfg", "none/gpsec.toml", "notes.md", "done/manifest.json"):
        (here / path).touch()
    (here / "results" / "hill").mkdir()
    (here / "results" / "hill" / "manifest.json").touch()
    before = sorted(here.rglob("*"))
    monkeypatch.setattr(batch, "run_scenarios", never_run)
    assert cli.main(arguments) == 2
    said = sentence(capsys)
    assert all(fragment in said for fragment in fragments), said
    assert sorted(here.rglob("*")) == before


def test_finished_scenarios_survive_the_failure_of_others(
    here: Path, faked: None, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("town", "refused", "killed", "hill"):
        make(here, name)
    assert cli.main(["run", "town", "refused", "killed", "hill", "--out", "all", "--jobs", "2", "--seed", "9"]) == 1
    captured = capsys.readouterr()
    assert "gpsec: error: scenario 'refused': refused.net.xml: expected drivable lanes, found none\n" in captured.err
    assert "scenario 'killed': its process ended early (SIGKILL: most likely" in captured.err
    assert "town: step lowered" in captured.err
    assert "town: running: 1/2 s, 3 vehicles, 12 tracks, 20.0x real time" in captured.err
    assert "hill: done\n" in captured.err
    assert "refused: failed\n" in captured.err
    assert captured.out == "tables of all\n"  # what SUMO prints is not among it
    for table in TABLES:
        assert (here / "all" / f"{table}.csv").read_text() == "scenario,seed\nhill,9\ntown,9\n"
    unfinished = json.loads((here / "all" / "manifest.json").read_text())["unfinished"]
    assert [entry["scenario"] for entry in unfinished] == ["refused", "killed"]
    assert unfinished[0]["reason"] == "refused.net.xml: expected drivable lanes, found none"
    hidden = here / ".all.partial"  # to go on with
    assert sorted(path.name for path in hidden.iterdir()) == [".lock", "hill", "town"]


def test_one_refused_scenario_ends_with_status_2_and_writes_nothing(
    here: Path, faked: None, capsys: pytest.CaptureFixture[str]
) -> None:
    make(here, "refused")
    assert cli.main(["run", "refused"]) == 2
    assert "Traceback" not in capsys.readouterr().err
    assert not (here / "results").exists()


def test_a_fault_of_ours_shows_where_it_happened(here: Path, faked: None, capsys: pytest.CaptureFixture[str]) -> None:
    make(here, "faulty")
    assert cli.main(["run", "faulty"]) == 1
    said = capsys.readouterr().err
    assert "scenario 'faulty': fault in gpsec (ZeroDivisionError: by hand)" in said
    assert "in fake_run" in said


def test_overwrite_replaces_the_run_and_keeps_notes(here: Path, faked: None) -> None:
    make(here, "town")
    former = here / "results" / "town"
    former.mkdir(parents=True)
    for name in ("manifest.json", "steps.parquet", "notes.md"):
        (former / name).write_text("former")
    assert cli.main(["run", "town", "--overwrite"]) == 0
    found = {path.name for path in former.iterdir()}
    assert found == {*(f"{table}.csv" for table in TABLES), "manifest.json", "notes.md"}
    assert "unfinished" not in json.loads((former / "manifest.json").read_text())


def test_parquet_is_asked_for_by_format(here: Path, faked: None, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[Path] = []
    monkeypatch.setattr(aftermath, "_write_parquet", written.append)
    make(here, "town")
    assert cli.main(["run", "town", "--out", "a"]) == 0
    assert written == []
    assert cli.main(["run", "town", "--out", "b", "--format", "parquet"]) == 0
    assert written == [here / "b"]
    assert cli.main(["run", "town", "--out", "c", "--format", "xlsx"]) == 2


INTERRUPTED = """
import sys, time
from pathlib import Path
sys.path.insert(0, {tests!r})
from gpsec import cli
from gpsec.console import aftermath
from gpsec.running import batch, impact
from test_cli import write_results

def run(scenario, folder, report):
    if scenario.name == "slow":
        (folder / "detection.csv").write_text("half")
        Path("slow-began").touch()
        time.sleep(60)
    write_results(scenario, folder)

if __name__ == "__main__":
    real = batch.run_scenarios
    batch.run_scenarios = lambda *args: real(*args[:4], run)
    aftermath.show_findings = lambda folder, all_: None
    impact.write_impact = lambda folder: None
    aftermath._report = lambda folder, messages: None
    sys.exit(cli.main(["run", "fast", "slow", "--out", "all", "--jobs", "1"]))
"""


def test_an_interrupt_keeps_what_has_finished(here: Path) -> None:
    make(here, "fast")
    make(here, "slow")
    (here / "script.py").write_text(textwrap.dedent(INTERRUPTED).format(tests=str(Path(__file__).parent)))
    command = [sys.executable, "script.py"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, start_new_session=True)
    try:
        deadline = time.monotonic() + 60.0
        while not (here / "slow-began").exists() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)  # as the terminal does: to every process
        _, err = process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 130, err.decode()
    assert b"Traceback" not in err
    assert b"interrupted; fast kept in" in err
    assert b"--resume goes on" in err
    assert (here / "all" / "events.csv").read_text() == "scenario,seed\nfast,1\n"
    manifest = json.loads((here / "all" / "manifest.json").read_text())
    assert manifest["unfinished"] == [{"scenario": "slow", "reason": "interrupted"}]
    assert sorted(path.name for path in here.iterdir()) == [
        *(".all.partial", "all", "fast", "script.py", "slow", "slow-began")
    ]


HUNG_UP = """
import os, sys
sys.path.insert(0, {tests!r})
from gpsec import cli
from gpsec.console import aftermath
from gpsec.running import batch, impact
from test_cli import write_results

def run(scenario, folder, report):
    with open("began", "w") as began:
        began.write("!")
    with open("go-on") as go_on:
        go_on.read(1)
    write_results(scenario, folder)

if __name__ == "__main__":
    real = batch.run_scenarios
    batch.run_scenarios = lambda *args: real(*args[:4], run)
    aftermath.show_findings = lambda folder, all_: None
    impact.write_impact = lambda folder: None
    aftermath._report = lambda folder, messages: None
    sys.exit(cli.main(["run", "town", "--out", "all"]))
"""


@pytest.mark.parametrize(("handler", "status"), [(signal.SIG_IGN, 0), (signal.SIG_DFL, 130)], ids=["nohup", "without"])
def test_with_nohup_a_run_goes_on_when_the_terminal_hangs_up(here: Path, handler: signal.Handlers, status: int) -> None:
    make(here, "town")
    (here / "script.py").write_text(textwrap.dedent(HUNG_UP).format(tests=str(Path(__file__).parent)))
    pipes = {}
    for name in ("began", "go-on"):
        os.mkfifo(name)
        pipes[name] = os.open(name, os.O_RDWR)
    process = subprocess.Popen(
        [sys.executable, "script.py"],
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, handler),
    )
    try:
        ready, _, _ = select([pipes["began"]], [], [], 60.0)
        assert ready
        os.killpg(process.pid, signal.SIGHUP)  # as the terminal does: to every process
        if handler == signal.SIG_IGN:
            os.write(pipes["go-on"], b"!")
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()
        for pipe in pipes.values():
            os.close(pipe)
    assert process.returncode == status, err.decode()
    assert b"Traceback" not in err
    assert (here / "all" / "manifest.json").exists() is (status == 0)


def test_check_says_every_error_and_no_traceback(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make(here, "a", "sede = 1")
    make(here, "b", "engine = 'x'")
    assert cli.main(["check", "a", "b"]) == 2
    assert [line.split(":")[2].strip() for line in capsys.readouterr().err.splitlines()] == [
        "a/gpsec.toml",
        "b/gpsec.toml",
    ]


def test_list_shows_a_line_a_part(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["list", "attacks"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert {"adaptive", "blind_drift", "drift"} <= {line.split()[0] for line in lines}
    assert len(lines) == len(ATTACKS)
    assert any(line.startswith("drift ") and "rate_mps = 0.2" in line for line in lines)
    assert cli.main(["list", "profiles"]) == 0
    assert {line.split()[0] for line in capsys.readouterr().out.splitlines()} == {
        *("dsd", "carla", "dsd_sim", "carla_sim", "nuscenes", "consumer", "urban")
    }
    assert cli.main(["list", "detectors"]) == 0
    names = {line.split()[0] for line in capsys.readouterr().out.splitlines()}
    learned = {"cusum", "isolation_forest", "lstm", "lstm_glr", "lstm_cusum"}
    assert names == {"chi_square", *learned, "innovation", "joint", "separation", "told", "never"}
    assert cli.main(["list", "responses"]) == 0
    assert {line.split()[0] for line in capsys.readouterr().out.splitlines()} == {
        *("none", "gate", "dead_reckoning", "ukf", "rollback", "consider_ukf", "ukf5", "ukf5_rollback")
    }
    assert cli.main(["list", "scenarios", "--dir", str(Path(__file__).parent.parent / "scenarios")]) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("town ")


COMMANDS = [
    "run",
    "replay",
    "show",
    "report",
    "table",
    "figure",
    "verify",
    "trace",
    "check",
    "import",
    "demand",
    "list",
    "new",
    "clean",
    "schema",
    "train",
    "calibrate",
    "paper",
    "stress",
    "sweep",
    "search",
    "bench-detector",
    "dataset",
    "judge",
    "image",
]


def test_all_commands_are_listed_in_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--help"]) == 0
    listed = re.findall(r"^  ([a-z-]+)  ", capsys.readouterr().out.partition("Commands:")[2], re.MULTILINE)
    assert listed == COMMANDS


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)])
def test_help_has_examples(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*command, "--help"]) == 0
    shown = capsys.readouterr().out
    assert "Examples:\n    gpsec " in shown


def test_no_arguments_show_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 0
    assert "Usage: gpsec" in capsys.readouterr().out


def test_the_schema_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "gpsec.toml"
