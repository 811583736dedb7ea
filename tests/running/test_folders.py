"""What goes when a run takes the place of another."""

import pytest

from gpsec.outcomes.seeds import POOLED
from gpsec.outcomes.tables import EFFECTS, LOG_ERRORS, MAP, POOLED_PREFIX, STEP_LOG, TABLES, TRACES, WORLD_TABLES
from gpsec.running.folders import written_by_runs

NAMES = [*TABLES, *WORLD_TABLES, EFFECTS, LOG_ERRORS, *(f"{POOLED_PREFIX}{name}" for name in POOLED)]


@pytest.mark.parametrize(
    "name", [*(f"{name}.csv" for name in NAMES), STEP_LOG, TRACES, MAP, "report.html", "manifest.json"]
)
def test_every_file_of_a_run_goes_with_it(name):
    """A table of a former run that stayed would stand for one of the new run."""
    assert written_by_runs(name)


def test_what_somebody_else_wrote_stays():
    assert not written_by_runs("notes.csv")
    assert not written_by_runs("pooled.txt")
