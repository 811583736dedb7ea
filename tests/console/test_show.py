"""`gpsec show` prints what is there, and names what is, where something else is asked for."""

import pytest

from gpsec.cli import main
from tests.report.conftest import write_run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("show") / "run")


def test_few_lines_by_default(folder, capsys):
    assert main(["show", str(folder)]) == 0
    assert len(capsys.readouterr().out.splitlines()) <= 15


def test_a_part_is_that_part_of_all(folder, capsys):
    assert main(["show", str(folder), "tables"]) == 0
    whole = capsys.readouterr().out
    for part in ("detection", "localization", "safety", "costs"):
        assert main(["show", str(folder), part]) == 0
        said = capsys.readouterr().out
        assert said
        assert said in whole


def test_a_file_is_shown_row_by_row(folder, capsys):
    assert main(["show", str(folder), "events", "--rows", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split()[:2] == ["scenario", "seed"]
    assert lines[-1] == "3 of 12 rows; --rows N shows more"


def test_an_unknown_table_is_refused_with_the_nearest(folder, capsys):
    assert main(["show", str(folder), "evnts"]) == 2
    said = capsys.readouterr().err
    assert "no table 'evnts' in this run: did you mean 'events'?" in said


def test_trace_without_a_vehicle_names_the_worst(folder, capsys):
    assert main(["trace", str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    assert all(line.startswith(f"gpsec trace {folder} ") and "--attack" in line for line in lines)


def test_list_alone_lists_its_kinds(capsys):
    assert main(["list"]) == 0
    assert capsys.readouterr().out.splitlines()[:3] == ["attacks", "detectors", "responses"]
