"""The data dictionary in results/README.md names what the code writes: all of it, and nothing else."""

import re
from pathlib import Path

import pytest
from pyarrow import parquet

from gpsec.core.geo import Projector
from gpsec.outcomes.state import OUTCOMES
from gpsec.outcomes.steps import StepLog
from gpsec.outcomes.tables import TABLES, read_table

from .scene import DEFENCES, DETECTORS, PLANS
from .story import tell

README = Path(__file__).parents[2] / "results" / "README.md"


def documented(file):
    """Columns that the section of that file names, in its order."""
    section = README.read_text("utf-8").split(f"\n## {file}\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (`.*?) \| .+ \|$", section, re.MULTILINE)
    return [name for row in rows for name in re.findall(r"`([^`]+)`", row)]


@pytest.mark.parametrize("name", TABLES)
def test_columns_of_tables(tmp_path, name):
    tell().outcomes.write(tmp_path, "lane", 1, replicates=5)
    assert set(documented(f"{name}.csv")) == set(read_table(tmp_path, name).columns)
    assert len(documented(f"{name}.csv")) == len(set(documented(f"{name}.csv")))


def test_columns_of_the_step_log(tmp_path):
    with StepLog(tmp_path / "steps.parquet", PLANS, DETECTORS, DEFENCES, ["e_0"], Projector("!")):
        pass
    names = {"<detector>": DETECTORS, "<defence>": ["+".join(defence) for defence in DEFENCES]}
    expected = set()
    for column in documented("steps.parquet"):
        mark = next((mark for mark in names if mark in column), None)
        expected |= {column.replace(mark, name) for name in names[mark]} if mark else {column}
    assert expected == set(parquet.read_schema(tmp_path / "steps.parquet").names)


def test_every_outcome_and_file_is_explained():
    text = README.read_text("utf-8")
    for outcome in OUTCOMES:
        assert f"\n| `{outcome}` | over " in text
    for name in [
        *(f"{table}.csv" for table in TABLES),
        "steps.parquet",
        "traces.parquet",
        "map.geojson",
        "manifest.json",
    ]:
        assert f"\n| `{name}` | " in text
