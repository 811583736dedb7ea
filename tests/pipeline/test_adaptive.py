"""The adaptive attacker in whole runs: it knows just what will be found, and disturbs nobody else."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from gpsec.attacks.probing import Probed, Question
from gpsec.core.errors import GpsecError
from gpsec.pipeline import run as loop
from gpsec.pipeline.batched import BatchedMethod
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.overrides import parse_set
from gpsec.scenario.worlds import with_worlds

from .conftest import Traffic, with_plans

WHEN: dict[str, Any] = {"share": 0.3, "start_after_s": [0.0, 2.0], "duration_s": [10.0, 12.0]}
BIAS: dict[str, Any] = {"attack": "constant_bias", "bias_m": 2.4, **WHEN}
DETECTORS = ("chi_square", "cusum", "isolation_forest", "lstm_glr", "innovation", "joint", "separation")


def scene(town: Scenario, plans: dict[str, dict[str, Any]], **changes: Any) -> Scenario:
    raw = town.model_dump(mode="json") | {"duration_s": 24.0, "defences": [{"detector": "never", "response": "none"}]}
    raw["detection"] |= {"detectors": list(DETECTORS), "rates": ["0.1/h", "1e-3/sample"]}
    return with_plans(Scenario.model_validate(raw | changes), plans)


class Witness:
    """Compares what was probed with what is found in the same step."""

    def __init__(self) -> None:
        self.probed: list[tuple[Question, Probed, Any]] = []
        self.compared = self.moved = 0
        self.different: list[tuple[float, float]] = []

    def begin(self, study: Any) -> None:
        self.names, self.thresholds = study.detectors, study.thresholds

    def see(self, view: Any, outcomes: Any, fleet: Any) -> None:
        for asked, found, fixes_m in self.probed:
            wanted = asked.columns
            for i, row in enumerate(asked.rows.tolist()):
                sent = np.flatnonzero((fixes_m[i] == view.tracks.fix_m[row]).all(axis=1))
                if not view.tracks.fix_valid[row]:
                    continue
                scored = view.answers.scored[row, wanted]
                threshold = self.thresholds[view.vehicles.profile[view.tracks.vehicle[row]], wanted]
                ratio = np.where(scored, view.answers.statistic[row, wanted] / threshold, 0.0).max()
                self.compared += int(scored.any())
                self.moved += int(ratio > 0.5)
                if not len(sent) or found.ratio[i, sent[0]] != ratio or found.scored[i, sent[0]] != scored.any():
                    self.different.append((float(found.ratio[i, sent[0]]) if len(sent) else -1.0, float(ratio)))
        self.probed.clear()


@pytest.fixture
def witness(monkeypatch: pytest.MonkeyPatch) -> Witness:
    """Return who is told of every probe."""
    found, ask = Witness(), BatchedMethod.probe

    def probe(self: BatchedMethod, number: int, asked: Question, tracks: Any, vehicles: Any, seen: Any, threads: Any):
        told = ask(self, number, asked, tracks, vehicles, seen, threads)
        fixes_m = seen.fix_m[tracks.vehicle[asked.rows]][:, np.newaxis] + asked.moved_m
        found.probed.append((asked, told, fixes_m))
        return told

    monkeypatch.setattr(BatchedMethod, "probe", probe)
    return found


@pytest.mark.parametrize(
    "target", [[*DETECTORS], ["joint@1e-3/sample"], ["cusum", "lstm_glr@1e-3/sample"]], ids=lambda one: one[0]
)
def test_what_an_attacker_is_told_is_what_is_found(
    town: Scenario,
    traffic: Traffic,
    replay: Callable[[Traffic], None],
    witness: Witness,
    tmp_path: Path,
    target: list[str],
) -> None:
    """To the last bit, for every registered detector: one alone, several operating points, and all at once."""
    replay(traffic)
    plans = {"white": {"attack": "adaptive", "target": target, "junctions": "move", **WHEN}}
    loop.run_scenario(scene(town, plans), tmp_path, lambda progress: None, onlooker=witness)
    assert witness.different == []
    assert witness.compared > 300
    assert witness.moved > 50


def test_in_closed_loop_too_and_its_victims_are_displaced_before_any_alarm(
    repository: Path, witness: Witness, tmp_path: Path
) -> None:
    """What the attacker is told of a vehicle that steers by what it believes, and heeds the alarm, is what is found."""
    sets = [
        "duration_s=14",
        "fleet.settle_s=1.0",
        "fleet.profile=carla",
        'detection.detectors=["chi_square"]',
        'defences=[{detector="chi_square",response="ukf"}]',
        'plans=[{attack="adaptive",target="chi_square",share=0.5,start_after_s=[0.0,1.0],duration_s=[10.0,10.0]}]',
    ]
    found = load_scenario(repository / "scenarios" / "slow_curve", [parse_set(text) for text in sets])
    world = with_worlds(found, [5])[-1]
    assert world.closed_loop.world is not None
    assert world.closed_loop.world.defence == "chi_square+ukf"
    loop.run_scenario(world, tmp_path, lambda progress: None, onlooker=witness)
    assert witness.different == []
    assert witness.compared > 300
    assert witness.moved > 50
    events = pd.read_csv(tmp_path / "events.csv")
    steered = events[(events["defence"] == "chi_square+ukf") & (events["attack_seconds"] > 5.0)]
    assert len(steered) > 2
    assert steered["detected"].mean() < 0.5
    assert steered["displaced_max_m"].median() > 0.3  # of a bias of 0.5 m, which every vehicle sees: 0.1


def test_other_plans_do_not_notice_it(
    town: Scenario, traffic: Traffic, replay: Callable[[Traffic], None], go: Callable[[Scenario], Path]
) -> None:
    replay(traffic)
    own_copy = {"attack": "adaptive", "target": "joint", "knowledge": "grey", **WHEN}
    beside, alone = (go(scene(town, plans)) for plans in ({"bias": BIAS, "grey": own_copy}, {"bias": BIAS}))
    for table in ("events", "vehicles", "detection", "safety"):
        both, one = (pd.read_csv(folder / f"{table}.csv") for folder in (beside, alone))
        left = both[both["attack"] != "grey"].reset_index(drop=True)
        assert len(left) < len(both)
        # Rows that are not there may have had empty cells, which make numbers of a column fractions.
        pd.testing.assert_frame_equal(left, one, check_dtype=False)


def test_the_more_an_attacker_knows_the_more_goes_unseen(
    town: Scenario, traffic: Traffic, replay: Callable[[Traffic], None], go: Callable[[Scenario], Path]
) -> None:
    replay(traffic)
    plans = {
        knowledge: {"attack": "adaptive", "target": "joint", "knowledge": knowledge, **WHEN}
        for knowledge in ("white", "grey", "queries")
    }
    defence = [{"detector": "never", "response": "none"}, {"detector": "joint", "response": "ukf5"}]
    events = pd.read_csv(go(scene(town, {**plans, "bias": BIAS}, defences=defence)) / "events.csv")
    behind = events[events["detector"] == "joint"].groupby("attack")
    unseen_m, delay_s = behind["max_undetected_deviation_m"].median(), behind["detection_delay_s"].mean()
    assert unseen_m["white"] > max(unseen_m["grey"], unseen_m["queries"])
    assert min(unseen_m["grey"], unseen_m["queries"]) > unseen_m["bias"]
    assert behind["detected"].mean()["white"] < 0.5
    assert delay_s["bias"] < min(delay_s["grey"], delay_s["queries"])
    assert (events["max_undetected_deviation_s"].dropna() >= 0.0).all()
    assert (events["max_undetected_deviation_s"] <= events["attack_seconds"]).any()


def test_a_target_that_is_no_detector_of_the_run_is_refused(town: Scenario, go: Callable[[Scenario], Path]) -> None:
    with pytest.raises(
        ValueError, match=r"plan 'a': target: no detector of the run is called 'jiont'; did you mean 'joint'"
    ):
        scene(town, {"a": {"attack": "adaptive", "target": "jiont"}})
    good = scene(town, {"a": {"attack": "adaptive", "target": "joint", **WHEN}})
    without = good.model_copy(update={"detection": good.detection.model_copy(update={"detectors": ("chi_square",)})})
    with pytest.raises(GpsecError, match="plan 'a': target: no detector of the run is called 'joint'"):
        go(without)
