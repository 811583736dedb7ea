"""How far attacks get before anybody notices, in the report and beside the tables of a run."""

from pathlib import Path

import pandas as pd
import pytest

from gpsec.report.impact import impact_tables
from gpsec.running.impact import IMPACT_COLUMNS, write_impact
from gpsec.running.results import Results, load

from .conftest import write_run


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return load(write_run(tmp_path_factory.mktemp("impact") / "run"))


def test_the_report_sets_attacks_beside_detectors(run: Results) -> None:
    [table] = impact_tables(run)
    rows = {(row.attack, row.name): [cell.text for cell in row.cells] for row in table.rows}
    assert {name for _, name in rows} == {"cusum", "never"}
    # Off from step 25 on, and seen in that very step: before, the estimate of the first defence is where it should be.
    assert rows["bias", "cusum"][1] == "100 %"
    assert float(rows["bias", "cusum"][2]) < 0.2
    assert all(len(row.cells) == len(table.headings) - 2 for row in table.rows)


def test_the_table_lies_beside_those_of_the_run(run: Results) -> None:
    write_impact(run.folder)
    table = pd.read_csv(run.folder / "impact.csv")
    assert list(table.columns) == IMPACT_COLUMNS
    assert len(table) == 3 * 2
    assert (table["n_events"] == 2).all()


def test_a_run_without_attacks_has_an_empty_table(run: Results, tmp_path: Path) -> None:
    for name in ("events", "vehicles", "detection"):
        table = pd.read_csv(run.folder / f"{name}.csv")
        (table if name != "events" else table[:0]).to_csv(tmp_path / f"{name}.csv", index=False)
    write_impact(tmp_path)
    assert list(pd.read_csv(tmp_path / "impact.csv").columns) == IMPACT_COLUMNS
