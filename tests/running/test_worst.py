"""The plan `worst`: which of a search it is, and on which seeds it may be run."""

import json
from pathlib import Path

import pandas as pd
import pytest

from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.running.search import WorstCase
from gpsec.running.search_space import make_space
from gpsec.running.worst import WORST, read_worst
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.scenario.overrides import parse_set


@pytest.fixture
def scenario(repository: Path) -> Scenario:
    return load_scenario(repository / "scenarios" / "sharp_turns", [parse_set("seed=3")])


@pytest.fixture
def finished(scenario: Scenario, tmp_path: Path) -> Path:
    """A search in which the random plan is worst on average, though the best of TPE is worst on other noise."""
    defence = Defence(detector="joint", response="ukf")
    wanted = WorstCase(scenario, defence, make_space("drift", ["rate_mps=0.01:0.5"], {"share": 0.7}), held_out=2)
    (tmp_path / "search.json").write_text(json.dumps(wanted.stated()), "utf-8")
    rates = {"default": 0.2, "tpe": 0.11, "random": 0.44}
    shares = {"default": (0.1, 0.1), "tpe": (0.5, 0.0), "random": (0.3, 0.4)}
    rows = [
        {"plan": plan, "parameters": json.dumps({"rate_mps": rates[plan]}), "out_of_lane_caused_share": share}
        for plan, both in shares.items()
        for share in both
    ]
    pd.DataFrame(rows).to_csv(tmp_path / "search.csv", index=False)
    return tmp_path


def test_the_worst_is_that_of_what_was_held_out(finished: Path, scenario: Scenario) -> None:
    found = read_worst(finished)
    assert (found.plan.name, found.plan.attack, found.plan.share) == (WORST, "drift", 0.7)
    assert found.plan.parameters.rate_mps == 0.44  # type: ignore[attr-defined]
    assert found.seeds == (3, 4, 5, 1004, 1005)
    assert found.into(scenario, [6, 7]).plans == (*scenario.plans, found.plan)
    elsewhere = scenario.model_copy(update={"name": "elsewhere"})
    assert found.into(elsewhere, [3]).plans[-1] == found.plan


@pytest.mark.parametrize("seed", [3, 5, 1004])
def test_seeds_that_the_search_has_seen_are_refused(finished: Path, scenario: Scenario, seed: int) -> None:
    with pytest.raises(GpsecError, match=rf"expected a seed that the search has not seen \(3, .* found {seed}: .*1006"):
        read_worst(finished).into(scenario, [9, seed])


def test_what_is_no_search_is_said(finished: Path, scenario: Scenario, capsys: pytest.CaptureFixture[str]) -> None:
    found = read_worst(finished)
    with pytest.raises(GpsecError, match="expected no plan called 'worst', found one"):
        found.into(found.into(scenario, [9]), [9])
    (finished / "search.csv").write_text("plan,parameters\ntpe,{}\n", "utf-8")
    with pytest.raises(GpsecError, match="expected the files of a search, found others"):
        read_worst(finished)
    (finished / "search.csv").unlink()
    assert cli.main(["run", "sharp_turns", "--worst", str(finished)]) == 2
    assert "expected the folder of a finished 'gpsec search', found no search.csv" in capsys.readouterr().err
