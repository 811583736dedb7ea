"""`gpsec stress`: the runs, the table by hand, and what the command says and writes."""

import re
from pathlib import Path

import pandas as pd
import pytest

from gpsec import cli
from gpsec.paper import stress as module
from gpsec.paper.stress import FACTORS, stressed
from gpsec.paper.stress_table import STRESS_COLUMNS, stress_rows
from gpsec.report.stress_page import markdown
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.mismatch import WorldSection
from tests.outcomes.test_dictionary import documented
from tests.report.conftest import EVIL, write_run

ROOT = Path(__file__).parents[2]
SCENARIO = ROOT / "scenarios" / "slow_curve"


@pytest.fixture
def scenario() -> Scenario:
    return load_scenario(SCENARIO)


def test_every_factor_is_a_world_of_its_own(scenario: Scenario) -> None:
    runs = stressed(scenario, list(FACTORS), [3, 4])
    every = [one for members in runs.values() for one in members]
    assert len({one.name for one in every}) == len(every) == 2 * len(FACTORS)
    assert [one.seed for one in runs["gnss_2"]] == [3, 4]
    worlds = [members[0].world for members in runs.values()]
    assert worlds[0] == WorldSection()
    assert all(one not in worlds[:place] for place, one in enumerate(worlds))
    for factor, members in runs.items():
        assert members[0].world.stated() == FACTORS[factor].world
        assert members[0].plans == scenario.plans


def test_every_detector_has_a_defence(scenario: Scenario) -> None:
    alone = scenario.model_copy(update={"defences": scenario.defences[:1]})
    [run] = stressed(alone, ["nothing"], [1])["nothing"]
    assert [one.name for one in run.defences] == [
        "never+none",
        *(f"{name}{rate}+ukf" for rate in ("", "@1e-3/sample") for name in scenario.detection.detectors),
    ]


def test_figures_by_hand(tmp_path: Path) -> None:
    # Six vehicles live for 8 s; CUSUM sees two of the six attacks, after 0.5 s, in the 35 of 40 steps from then on.
    table = stress_rows([write_run(tmp_path / "run", log=False)])
    assert list(table.columns) == list(STRESS_COLUMNS)
    bias = table[(table["attack"] == "bias") & (table["detector"] == "cusum")].iloc[0]
    assert (bias["n_vehicles"], bias["n_events"], bias["detected_share"]) == (6, 2, 1.0)
    assert bias["vehicle_hours"] == pytest.approx(6 * 8.0 / 3600.0)
    assert bias["delay_mean_s"] == pytest.approx(0.5)
    assert bias["f1"] == pytest.approx(2.0 * 35.0 / (2.0 * 35.0 + 5.0))
    assert bias["false_alarms_per_vehicle_hour"] == 0.0
    assert table["line_touched"].eq(0).all()


def test_runs_of_several_seeds_are_pooled(tmp_path: Path) -> None:
    folders = [write_run(tmp_path / name, log=False) for name in ("one", "other")]
    table = stress_rows(folders)
    assert table["n_vehicles"].eq(12).all()
    assert table.loc[table["attack"] == "bias", "n_events"].eq(4).all()


def test_every_column_is_in_the_data_dictionary() -> None:
    assert documented("stress.csv") == ["factor", "title", *STRESS_COLUMNS]


def test_every_factor_and_key_is_on_the_page_of_the_world() -> None:
    page = (ROOT / "docs" / "world.md").read_text("utf-8")
    for name, factor in FACTORS.items():
        assert f"| `{name}`: {factor.title} |" in page
    named = set(re.findall(r"`([a-z_]+)`", page.split("## Keys")[1].split("## Multipath")[0]))
    assert set(WorldSection.model_fields) <= named


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Put runs that are there already in the place of those that would take minutes."""

    def ready(scenarios: list[Scenario], folder: Path, *others: object) -> list[Path]:
        return [write_run(folder / scenario.name, log=False) for scenario in scenarios]

    monkeypatch.setattr(module, "run_missing", ready)
    return tmp_path / "out"


def test_the_command_writes_table_and_pages(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["stress", str(SCENARIO), "--out", str(made), "--factor", "nothing", "--factor", "gnss_2", "--seeds", "5-6"]
    assert cli.main(given) == 0
    table = pd.read_csv(made / "stress.csv", keep_default_na=False)
    assert list(table["factor"].unique()) == ["nothing", "gnss_2"]
    runs = sorted(path.name for path in (made / "runs").glob("slow*"))
    assert runs == [f"slow_curve-{factor}-{seed}" for factor in ("gnss_2", "nothing") for seed in (5, 6)]
    text = (made / "stress.md").read_text("utf-8")
    assert "| GNSS noise × 2 | 0.00 |" in text
    assert "| nothing | 6/6" not in text
    page = (made / "stress.html").read_text("utf-8")
    assert EVIL not in page  # a plan's name is what somebody else has chosen
    for figure in ("false_alarms", "touches", "delays"):
        assert f'id="{figure}"' in page
    said = capsys.readouterr()
    assert "GNSS noise × 2" in said.out
    assert "stress.csv, stress.html, stress.md" in said.out + said.err


def test_without_an_attack_there_are_honest_vehicles(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", log=False)
    events = pd.read_csv(folder / "events.csv")
    events.iloc[:0].to_csv(folder / "events.csv", index=False)
    table = stress_rows([folder])
    assert list(table["attack"].unique()) == ["none"]
    assert table["f1"].isna().all()
    lines = list(markdown(table.assign(factor="nothing", title="nothing")))
    assert any(line.startswith("| nothing | ") for line in lines)


def test_each_false_alarm_rate_has_its_tables(tmp_path: Path) -> None:
    found = stress_rows([write_run(tmp_path / "run", log=False)]).assign(factor="nothing", title="nothing")
    rare = found[found["detector"] == "cusum"]
    often = rare.assign(detector="cusum@1e-3/sample", false_alarms_per_vehicle_hour=36.0)
    text = "\n".join(markdown(pd.concat([found, often])))
    first, second = text.split("## Thresholds at ")[1:]
    assert first.startswith("0.1/h")
    assert second.startswith("1e-3/sample")
    assert "| nothing | 0.00 |" in first
    assert "| nothing | 36.0 |" in second
    assert "@" not in second


def test_an_unknown_factor_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["stress", str(SCENARIO), "--out", str(tmp_path / "out"), "--factor", "gns_2"]) == 2
    said = capsys.readouterr().err
    assert "--factor gns_2: unknown factor: did you mean 'gnss_2'?" in said
    assert not (tmp_path / "out").exists()


def test_one_seed_or_several_are_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for seeds, says in (("1-2", "--seeds 1-2: expected it without --seed"), ("2-1", "expected ranges that go up")):
        alone = ["--seed", "1"] if seeds == "1-2" else []
        assert cli.main(["stress", str(SCENARIO), "--out", str(tmp_path / "out"), "--seeds", seeds, *alone]) == 2
        assert says in capsys.readouterr().err


@pytest.mark.slow
def test_a_call_goes_on_where_an_earlier_one_stopped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["stress", str(SCENARIO), "--out", str(tmp_path / "out"), "--duration", "20", "--factor", "nothing"]
    assert cli.main(given) == 0
    run = tmp_path / "out" / "runs" / "slow_curve-nothing-1" / "manifest.json"
    before = run.stat().st_mtime_ns
    capsys.readouterr()
    assert cli.main([*given, "--factor", "camera_2"]) == 0
    assert run.stat().st_mtime_ns == before
    table = pd.read_csv(tmp_path / "out" / "stress.csv")
    assert list(table["factor"].unique()) == ["nothing", "camera_2"]
