"""A whole run with either engine: the same tables."""

from pathlib import Path

import pandas as pd
import pytest

from gpsec.attacks.plans import plan_config
from gpsec.detection import models
from gpsec.detection.calibration import Calibrated
from gpsec.detection.models import ProfileModel
from gpsec.pipeline.run import run_scenario
from gpsec.scenario import Scenario, load_scenario

from .drive import ATTACKS, SCENARIOS, WINDOW_S, learned_for

TABLES = ("detection", "events", "localization", "safety", "vehicles")
TOLERANCE = 1e-6


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders of one run with each engine."""
    thresholds = {
        "chi_square": 4.0,
        "cusum": 6.0,
        "isolation_forest": 0.62,
        "lstm_glr": 4.0,
        "innovation": 12.0,
        "joint": 20.0,
    }
    calibrated = {
        rate: {name: Calibrated(factor * threshold, 0.0) for name, threshold in thresholds.items()}
        for rate, factor in (("1e-3/sample", 1.0), ("0.1/h", 1.2))
    }
    known = {
        (profile, "tracked"): ProfileModel(learned_for(seed), calibrated)
        for seed, profile in enumerate(("carla", "consumer"))
    }
    folders = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(models, "bundled", lambda: known)
        for engine in ("batched", "reference"):
            folders[engine] = tmp_path_factory.mktemp(engine)
            run_scenario(_scenario(engine), folders[engine], lambda progress: None)
    return folders


def _scenario(engine: str) -> Scenario:
    scenario = load_scenario(SCENARIOS / "town")
    changes = {
        "engine": engine,
        "duration_s": 25.0,
        "fleet": scenario.fleet.model_copy(update={"equipped_share": 0.06, "settle_s": 2.0}),
        "plans": tuple(plan_config(table | WINDOW_S, "parity") for table in ATTACKS[:3]),
        "outcomes": scenario.outcomes.model_copy(update={"bootstrap": 50}),
    }
    return scenario.model_copy(update=changes)


@pytest.mark.parametrize("table", TABLES)
def test_both_engines_write_the_same_tables(results: dict[str, Path], table: str):
    batched, reference = (pd.read_csv(results[engine] / f"{table}.csv") for engine in ("batched", "reference"))
    assert len(batched) > 3
    pd.testing.assert_frame_equal(batched, reference, check_exact=False, rtol=TOLERANCE, atol=TOLERANCE)


def test_the_run_was_worth_comparing(results: dict[str, Path]):
    events = pd.read_csv(results["reference"] / "events.csv")
    assert events["attack"].nunique() == 3
    assert events["detected"].astype(bool).mean() > 0.2
    assert events["rmse_xy_m"].max() > 0.5
