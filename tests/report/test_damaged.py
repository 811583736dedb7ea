"""Whatever was done to the files of a run: a report, or one sentence and exit status 2."""

import csv
import io
import json
import shutil

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.outcomes.columns import COLUMNS, COUNTS, FLAGS, TEXTS, read_checked
from gpsec.outcomes.state import OUTCOMES
from gpsec.outcomes.tables import TABLES
from gpsec.running.results import load

from .conftest import write_run

CELLS = ["", "abc", "-1", "0", "0.5", "1e999", "nan", "True", "none", "9" * 30, "\x00", "é", '"', "a\nb", "\ud800"]
VALUES = [None, True, -1, 0, 2**70, 1.5, float("nan"), "", "x", "\ud800", "../x", [], [[]], {}, {"a": 1}, ["x"]]
SLOW = {"deadline": None, "derandomize": True, "suppress_health_check": [HealthCheck.function_scoped_fixture]}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return a run without digests, so that nothing but the content of its files can be held against them."""
    return write_run(tmp_path_factory.mktemp("damaged") / "whole")


@pytest.fixture
def folder(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "run")


def report(folder, whole, name, content, capsys):
    """Write a report of the run with that file and compare it with another run; restore it, and return the status."""
    (folder / name).write_bytes(content)
    try:
        for command in (["report", str(folder), "--geojson"], ["report", str(whole), str(folder)]):
            capsys.readouterr()
            status = cli.main(command)
            said = capsys.readouterr().err.splitlines()
            assert (status, len(said)) in ((0, 0), (2, 1))
            if status == 2:
                assert said[0].startswith("gpsec: error: ")
                return status
        return 0
    finally:
        shutil.copyfile(whole / name, folder / name)


def flipped(data, content):
    """Return the bytes with one of them changed, some left out, or cut short."""
    at = data.draw(st.integers(0, max(len(content) - 1, 0)))
    how = data.draw(st.sampled_from(["set", "cut", "drop", "twice"]))
    if how == "set":
        return content[:at] + bytes([data.draw(st.integers(0, 255))]) + content[at + 1 :]
    length = data.draw(st.integers(1, 40))
    middle = {"cut": b"", "drop": content[at + length :], "twice": content[at:] + content[at : at + length]}[how]
    return content[:at] + middle


def places_in(document, path=()):
    """Return the paths of all values in a JSON document."""
    found = [path]
    items = document.items() if isinstance(document, dict) else enumerate(document)
    for key, value in items:
        found += places_in(value, (*path, key)) if isinstance(value, dict | list) else [(*path, key)]
    return found


def edited(data, content):
    """Return a JSON document in which a value is another, or missing."""
    document = {"all": json.loads(content)}
    path = data.draw(st.sampled_from(places_in(document)[1:]))
    owner = document
    for key in path[:-1]:
        owner = owner[key]
    if len(path) > 1 and data.draw(st.booleans()):
        del owner[path[-1]]
    else:
        owner[path[-1]] = data.draw(st.sampled_from(VALUES))
    return json.dumps(document["all"]).encode()


def mangled(data, content):
    """Return a table in which a cell, a row or a column is another, missing or there twice."""
    rows = list(csv.reader(io.StringIO(content.decode())))
    row, column = data.draw(st.integers(0, len(rows) - 1)), data.draw(st.integers(0, len(rows[0]) - 1))
    how = data.draw(st.sampled_from(["cell", "cell", "cell", "row", "twice", "column", "ragged", "header"]))
    if how == "cell":
        rows[row][column] = data.draw(st.sampled_from(CELLS))
    elif how == "row":
        del rows[row]
    elif how == "twice":
        rows.append(rows[row])
    elif how == "column":
        rows = [line[:column] + line[column + 1 :] for line in rows]
    elif how == "ragged":
        rows[row] = rows[row][:column]
    else:
        rows = rows[:1]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode("utf-8", "surrogatepass")


@settings(max_examples=25, **SLOW)
@given(data=st.data())
def test_any_manifest(folder, whole, data, capsys):
    content = (whole / "manifest.json").read_bytes()
    report(folder, whole, "manifest.json", data.draw(st.sampled_from([edited, edited, flipped]))(data, content), capsys)


@pytest.mark.parametrize("name", TABLES)
@settings(max_examples=8, **SLOW)
@given(data=st.data())
def test_any_table(folder, whole, data, capsys, name):
    content = (whole / f"{name}.csv").read_bytes()
    report(folder, whole, f"{name}.csv", data.draw(st.sampled_from([mangled, mangled, flipped]))(data, content), capsys)


@settings(max_examples=20, **SLOW)
@given(data=st.data())
def test_any_map(folder, whole, data, capsys):
    content = (whole / "map.geojson").read_bytes()
    report(folder, whole, "map.geojson", data.draw(st.sampled_from([edited, edited, flipped]))(data, content), capsys)


@pytest.mark.parametrize("name", ["manifest.json", "map.geojson", *(f"{table}.csv" for table in TABLES)])
@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"[]", b"a,b\n1,2\n"])
def test_other_files(folder, whole, capsys, name, content):
    assert report(folder, whole, name, content, capsys) == 2


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        (
            "events.csv",
            "rmse_xy_m",
            "rmse",
            "expected a table of a finished run, found no column 'rmse_xy_m'",
        ),
        (
            "safety.csv",
            ",off_road,",
            ",OFF,",
            "expected a table of a finished run, found no column 'off_road'",
        ),
        ("events.csv", "True", "maybe", "row 1: expected True or False, found 'maybe'"),
        (
            "events.csv",
            ",out_of_lane,",
            ",over_the_moon,",
            "column 'outcome', row 2: expected one of line_touched, none",
        ),
        ("manifest.json", '"parameters"', '"parameter"', "scenarios.0.plans.0.parameters: field required"),
        (
            "manifest.json",
            '"steps": 80',
            '"steps": "80"',
            "0.steps: input should be a valid integer, found 80",
        ),
        ("manifest.json", '"libsumo"', '"sumo"', "scenarios.0.versions: expected the one of libsumo, found none"),
        ("map.geojson", "LineString", "Line", "map.geojson: expected a GeoJSON collection of lanes and zones"),
        (
            "vehicles.csv",
            "lane,1,b,",
            "lane,1,z,",
            "vehicle 'b' of 'lane': expected a row without an attack",
        ),
        ("error_bands.csv", "never+none", "never+nine", "defence 'never+nine' is not in safety.csv: did you mean"),
        ("curves.csv", "lane,", "street,", "scenario 'street' is not in the manifest: known: lane"),
        (
            "places.csv",
            ",dsd,",
            ",carla,",
            "of detection.csv, found 'lane' with 'carla'",
        ),
    ],
)
def test_what_is_wrong_is_named(folder, name, old, new, said):
    content = (folder / name).read_text()
    assert old in content
    (folder / name).write_text(content.replace(old, new))
    with pytest.raises(GpsecError) as caught:
        load(folder)
    assert said in str(caught.value)
    assert str(folder) in str(caught.value)


def test_a_changed_log_of_steps_is_refused_before_it_is_read(folder, capsys):
    stated = json.loads((folder / "manifest.json").read_text())
    stated["tables"] = {"steps.parquet": "0" * 64}
    (folder / "manifest.json").write_text(json.dumps(stated))
    assert cli.main(["report", str(folder)]) == 2
    assert "steps.parquet: expected the steps that the run has written" in capsys.readouterr().err


@pytest.mark.parametrize("name", TABLES)
def test_columns_are_those_that_are_written(whole, name):
    frame = read_checked(whole, name)
    assert tuple(frame.columns) == COLUMNS[name]
    for column in frame:
        flag = column in FLAGS or column.endswith("in_junction")
        kind = "ib"[flag] if flag or column in COUNTS | set(OUTCOMES) else "f"
        assert column in TEXTS or frame[column].dtype.kind == kind
