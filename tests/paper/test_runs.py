from pathlib import Path

import pytest

from gpsec.core.errors import GpsecError
from gpsec.paper import runs
from gpsec.running.workers import Failure, Outcome
from gpsec.scenario import load_scenario

SCENARIO = load_scenario(Path(__file__).parents[2] / "scenarios" / "slow_curve")


@pytest.mark.parametrize(
    ("outcome", "error", "said"),
    [
        (Outcome(failures=[Failure("slow_curve", "no net")]), GpsecError, "^scenario 'slow_curve': no net$"),
        (Outcome(failures=[Failure("slow_curve", "a fault", "a trace")]), GpsecError, "^a trace scenario"),
        (Outcome(interrupted=True), KeyboardInterrupt, "^$"),
    ],
)
def test_a_run_that_is_missing_is_said(tmp_path, monkeypatch, outcome, error, said):
    monkeypatch.setattr(runs, "run_scenarios", lambda *args: outcome)
    with pytest.raises(error, match=said):
        runs.run_missing([SCENARIO], tmp_path / "runs", 1, lambda progress: None)
    assert (tmp_path / "runs").is_dir()
