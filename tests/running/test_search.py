"""The search for the worst attack: what it may choose, that it can be stopped, and what it is judged on."""

import sys
from pathlib import Path

import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.running.search import RESULT, TRIALS, WorstCase, run_search, tasks_of
from gpsec.running.search_score import caused, harm
from gpsec.running.search_space import make_space
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.scenario.overrides import parse_set

DEFENCE = Defence(detector="chi_square", response="ukf")
WHEN = {"share": 1.0, "start_after_s": [0.0, 1.0], "duration_s": [8.0, 8.0]}


@pytest.fixture(scope="module")
def scenario(repository: Path) -> Scenario:
    changes = ["duration_s=20", "fleet.settle_s=4", "seed=3"]
    return load_scenario(repository / "scenarios" / "sharp_turns", [parse_set(change) for change in changes])


def search(scenario: Scenario, **changes: object) -> WorstCase:
    space = make_space("constant_bias", ["bias_m=0.5:12", "side=as_given,random"], WHEN)
    return WorstCase(scenario, DEFENCE, space, **{"plans": 4, "together": 2, "held_out": 1, **changes})  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def finished(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("search")
    told: list[str] = []
    wanted = search(scenario)
    run_search(wanted, out, lambda progress: told.append(f"{progress.scenario} {progress.stage}"))
    assert sum(one.endswith("done") for one in told) == tasks_of(wanted) == 5
    return out


def test_the_best_is_judged_on_what_was_not_searched(finished: Path) -> None:
    trials, result = pd.read_csv(finished / TRIALS), pd.read_csv(finished / RESULT)
    assert trials.groupby(["batch", "sampler"]).size().tolist() == [2, 2, 2, 2]
    assert trials["bias_m"].between(0.5, 12.0).all()
    assert set(trials["side"]) <= {"as_given", "random"}
    assert list(zip(result["plan"], result["judged_on"], strict=True)) == [
        (plan, where) for plan in ("default", "tpe", "random") for where in ("other noise", "other traffic")
    ]
    assert (result["n_vehicles"] > 3).all()
    best = trials.groupby("sampler")["score"].max()
    assert result["searched_score"].dropna().unique().tolist() == pytest.approx([best["tpe"], best["random"]])
    for name in ("out_of_lane_caused_share", "line_touched_caused_share", "detected_share"):
        assert (result[f"{name}_lo"] <= result[name]).all()
        assert (result[name] <= result[f"{name}_hi"]).all()
    # A bias of metres puts who does nothing against it out of the lane.
    assert result["undefended_out_of_lane_caused_share"].max() > 0.5


def test_a_search_that_goes_on_is_one_that_never_stopped(finished: Path, scenario: Scenario, tmp_path: Path) -> None:
    trials = (finished / TRIALS).read_text("utf-8").splitlines(keepends=True)
    (tmp_path / "search.json").write_bytes((finished / "search.json").read_bytes())
    (tmp_path / TRIALS).write_text("".join(trials[:5]), "utf-8")
    run_search(search(scenario), tmp_path, lambda progress: None)
    for name in (TRIALS, RESULT):
        assert (tmp_path / name).read_bytes() == (finished / name).read_bytes()


def test_another_search_and_other_files_are_refused(finished: Path, scenario: Scenario, tmp_path: Path) -> None:
    with pytest.raises(GpsecError, match="expected the same search as before"):
        run_search(search(scenario, objective="undetected"), finished, lambda progress: None)
    (tmp_path / "notes.txt").write_text("mine", "utf-8")
    with pytest.raises(GpsecError, match="expected an empty folder, or that of this search"):
        run_search(search(scenario), tmp_path, lambda progress: None)


def test_damaged_trials_are_refused(finished: Path, scenario: Scenario, tmp_path: Path) -> None:
    (tmp_path / "search.json").write_bytes((finished / "search.json").read_bytes())
    trials = (finished / TRIALS).read_text("utf-8").splitlines(keepends=True)
    (tmp_path / TRIALS).write_text("".join(trials[:4]), "utf-8")
    with pytest.raises(GpsecError, match="expected whole batches of 4 trials"):
        run_search(search(scenario), tmp_path, lambda progress: None)


def test_without_optuna_it_is_said_what_to_install(
    scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(GpsecError, match=r"pip install 'gpsec\[search\]'"):
        run_search(search(scenario), tmp_path, lambda progress: None)


def test_a_score_counts_what_the_attack_has_caused() -> None:
    events = pd.DataFrame(
        {
            "defence": ["joint+ukf"] * 4 + ["never+none"],
            "outcome": ["off_road", "out_of_lane", "line_touched", "none", "off_road"],
            "twin_outcome": ["none", "out_of_lane", "none", "line_touched", "none"],
            "max_cross_track_m": [20.0, 2.0, 1.0, 1.0, 9.0],
            "max_undetected_deviation_m": [0.2, 0.4, 0.6, 0.8, 9.0],
        }
    )
    assert caused(events[:4], "out_of_lane").tolist() == [1.0, 0.0, 0.0, 0.0]
    assert caused(events[:4], "line_touched").tolist() == [1.0, 0.0, 1.0, -1.0]
    # Of one score, the plan is worse whose errors are larger: 14 m over four vehicles, 10 m of which are counted.
    assert harm(events, "joint+ukf", "out_of_lane") == pytest.approx(0.25 + 0.001 * 14.0 / 4.0)
    assert harm(events, "joint+ukf", "undetected") == pytest.approx(0.5 + 0.001 * 14.0 / 4.0)
    assert harm(events, "none+ukf", "undetected") == 0.0


def test_bounds_that_a_search_needs_are_allowed() -> None:
    space = make_space("drift", ["rate_mps=0.005:0.5"], {})
    assert space.plan("slow", {"rate_mps": 0.005}).parameters.rate_mps == 0.005  # type: ignore[attr-defined]
    assert [one.ends for one in space.free] == [(0.005, 0.5)]


@pytest.mark.parametrize(
    ("attack", "free", "fixed", "said"),
    [
        ("drfit", ["rate_mps=0.1:0.2"], {}, "unknown attack 'drfit': did you mean 'drift'"),
        ("drift", [], {}, r"expected at least one parameter of 'drift' \(.*rate_mps.*\), found none"),
        ("jamming", [], {}, "expected an attack with parameters, found one without"),
        ("drift", ["rate=0.1:0.2"], {}, "'drift' has no such parameter: did you mean 'rate_mps'"),
        ("drift", ["rate_mps=0.3:0.1"], {}, "expected a lower bound below the upper one, found 0.3 and 0.1"),
        ("drift", ["rate_mps=0.3"], {}, "expected two numbers, such as rate_mps=1:2, found '0.3'"),
        ("drift", ["rate_mps=0.1:nan"], {}, "expected two numbers"),
        ("drift", ["rate_mps=0.1:7"], {}, "rate_mps: expected a number less than or equal to 0.5, found 7"),
        ("drift", ["side=random"], {}, "expected two or more choices, such as side=one,other, found 'random'"),
        ("drift", ["side=random,up"], {}, "side: expected"),
        ("drift", ["rate_mps=0.1:0.2", "rate_mps=0.1:0.3"], {}, "expected each parameter once"),
        ("drift", ["rate_mps=0.1:0.2"], {"rate_mps": 0.1}, "expected each parameter once"),
        ("drift", ["rate_mps=0.1:0.2"], {"durations_s": 1}, "unknown key: did you mean 'duration_s'"),
    ],
)
def test_what_cannot_be_searched_is_said(attack: str, free: list[str], fixed: dict[str, object], said: str) -> None:
    with pytest.raises(GpsecError, match=said):
        make_space(attack, free, fixed)
