"""What `import gpsec` offers does what the command line does, and prints nothing."""

import multiprocessing
import subprocess
import sys
from pathlib import Path

import pytest

import gpsec
from gpsec import cli
from gpsec.core import shipped
from gpsec.core.errors import MachineError
from gpsec.outcomes.tables import TABLES
from gpsec.running import batch
from gpsec.running.workers import Failure, Outcome

# As in a script, which the processes of a run must not begin anew, or a cell of a notebook.
SCRIPT = """
import gpsec

stages = []
run = gpsec.run("slow_curve", "made", duration_s=1.0, seed=3, report=lambda progress: stages.append(progress.stage))
assert stages[-1] == "done", stages
assert gpsec.run("slow_curve", "made", duration_s=1.0, seed=3, resume=True).folder == run.folder
assert gpsec.check("slow_curve").lanes > 0
open("once", "x").close()
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_plain_script_makes_the_tables_of_the_command_line(here: Path) -> None:
    (here / "script.py").write_text(SCRIPT)
    done = subprocess.run([sys.executable, "script.py"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert (here / "once").exists()
    arguments = ["run", "slow_curve", "--duration", "1", "--seed", "3", "--no-report", "--out", "told"]
    assert cli.main(arguments) == 0
    for table in TABLES:
        assert (here / "made" / f"{table}.csv").read_bytes() == (here / "told" / f"{table}.csv").read_bytes()
    stated = [gpsec.load(here / name).scenarios[0] for name in ("made", "told")]
    assert stated[0].keys() == stated[1].keys()
    assert stated[0]["fingerprint"] == stated[1]["fingerprint"]
    assert sorted(path.name for path in here.iterdir()) == ["made", "once", "script.py", "told"]


def test_keywords_are_keys_of_the_scenario() -> None:
    read = gpsec.read_scenario("slow_curve", seed=2, fleet={"profile": {"dsd": 0.5, "carla": 0.5}}, threads=2)
    assert (read.seed, read.threads, read.fleet.profile) == (2, 2, {"dsd": 0.5, "carla": 0.5})
    assert read.fleet.association == "tracked"
    assert gpsec.read_scenario(read) is read
    again = gpsec.read_scenario(read, **{"fleet.association": "nearest"}, plans={"drift": {"rate_mps": 0.3}}, seed=5)
    assert (again.seed, again.fleet.association, again.fleet.profile) == (5, "nearest", read.fleet.profile)
    rates = {plan.name: getattr(plan.parameters, "rate_mps", None) for plan in again.plans}
    assert rates["drift"] == 0.3
    assert len(again.plans) == len(read.plans)
    own = gpsec.read_scenario(read, plans=(*read.plans[:1], {"attack": "noise", "sigma_m": 2.0}))
    assert own.plans[0] == read.plans[0]
    assert own.plans[1].parameters.model_dump() == {"sigma_m": 2.0}
    with pytest.raises(gpsec.GpsecError, match="seed=-1: seed: expected at least 0, found -1"):
        gpsec.read_scenario(read, seed=-1)
    with pytest.raises(gpsec.GpsecError, match="duration=5: unknown key 'duration': did you mean 'duration_s'"):
        gpsec.read_scenario("slow_curve", duration=5)
    with pytest.raises(gpsec.GpsecError, match=r"plans\.drift\.rate=1: plans\.\d: .*'rate_mps'"):
        gpsec.read_scenario("slow_curve", plans={"drift": {"rate": 1}})


@pytest.mark.parametrize(
    ("outcome", "error", "words"),
    [
        (Outcome(failures=[Failure("slow_curve", "no lanes")]), gpsec.GpsecError, "scenario 'slow_curve': no lanes"),
        (Outcome(failures=[Failure("slow_curve", "fault", "Trace", MachineError)]), MachineError, "fault"),
        (Outcome(interrupted=True), KeyboardInterrupt, None),
    ],
)
def test_what_fails_is_raised_and_leaves_the_folder_as_it_was(
    outcome: Outcome, error: type[BaseException], words: str | None, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batch, "run_scenarios", lambda *arguments: outcome)
    with pytest.raises(error, match=words) as raised:
        gpsec.run("slow_curve", "out")
    assert list(here.iterdir()) == []
    notes = getattr(raised.value, "__notes__", [])
    assert notes == [failure.details for failure in outcome.failures if failure.details]


def test_a_folder_that_holds_something_is_refused(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "run_scenarios", lambda *arguments: pytest.fail("it was run"))
    (here / "out").mkdir()
    (here / "out" / "notes.md").touch()
    for options in ({}, {"overwrite": True}, {"resume": True}):
        with pytest.raises(gpsec.GpsecError, match="out: expected an empty or new folder"):
            gpsec.run("slow_curve", "out", **options)
    with pytest.raises(gpsec.GpsecError, match="resume and overwrite: expected one of them"):
        gpsec.run("slow_curve", "new", overwrite=True, resume=True)
    assert [path.name for path in here.iterdir()] == ["out"]


def test_resume_and_overwrite_are_not_given_together(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = str(shipped.scenarios() / "slow_curve")
    assert cli.main(["run", folder, "--resume", "--overwrite"]) == 2
    assert "resume and overwrite: expected one of them" in capsys.readouterr().err
    assert list(here.iterdir()) == []


def test_all_that_is_offered_is_there() -> None:
    for name in gpsec.__all__:
        assert getattr(gpsec, name).__doc__, name
    assert set(gpsec.__all__) <= set(dir(gpsec))
    with pytest.raises(AttributeError, match="no attribute 'rnu'"):
        gpsec.rnu  # noqa: B018


def test_a_process_that_may_start_no_others_says_so(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(multiprocessing.current_process()._config, "daemon", True)  # type: ignore[attr-defined]
    for call in (
        lambda: gpsec.run("slow_curve", "out"),
        lambda: gpsec.check("slow_curve"),
        lambda: gpsec.train("models"),
    ):
        with pytest.raises(gpsec.GpsecError, match=r"multiprocessing\.Pool may not: expected a thread"):
            call()
    assert list(here.iterdir()) == []
