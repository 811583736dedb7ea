import json
import shutil

import numpy as np
import pandas as pd
import pytest

from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.outcomes.tables import LARGE_TABLES, TABLES
from gpsec.running.results import load, unit, write_parquet, write_spreadsheets

from .conftest import PLANS, write_run


def test_frames_have_types(run):
    assert list(run.events["attack"].cat.categories) == list(PLANS[1:])
    assert run.events["detected"].dtype == np.bool_
    assert run.safety["out_of_lane"].dtype == np.int64
    assert run.detection["precision"].dtype == np.float64
    assert {name for name in TABLES if len(getattr(run, name)) > 0} == set(TABLES)


def test_units_of_columns():
    assert unit("detection_delay_s") == "s"
    assert unit("rmse_cross_track_m_lo") == "m"
    assert unit("false_alarms_per_vehicle_hour_hi") == "1/h"
    assert unit("vehicle_hours") == "h"
    assert unit("speed_mps") == "m/s"
    assert unit("lat_deg") == "°"
    assert unit("precision") == unit("n_events") == unit("attack") == ""


def test_steps_of_some_vehicles(run):
    steps = run.steps("lane", ["b", "c"])
    assert set(steps["vehicle_id"]) == {"b", "c"}
    assert set(run.steps("lane")["vehicle_id"]) > {"b", "c", "f"}


def test_a_folder_can_be_moved(run_folder, tmp_path):
    moved = shutil.copytree(run_folder, tmp_path / "else where")
    assert len(load(moved).events) == len(load(run_folder).events)


def test_what_did_not_finish_is_known(run_folder, tmp_path):
    folder = shutil.copytree(run_folder, tmp_path / "part")
    stated = json.loads((folder / "manifest.json").read_text())
    stated["unfinished"] = [{"scenario": "town", "reason": "interrupted"}]
    (folder / "manifest.json").write_text(json.dumps(stated))
    assert load(folder).unfinished == {"town": "interrupted"}


def break_table(folder):
    (folder / "events.csv").write_bytes(b"\xff\xfe\x00")


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda folder: shutil.rmtree(folder), "expected the folder of a run, found nothing"),
        (lambda folder: (folder / "manifest.json").unlink(), "found no manifest.json in it"),
        (lambda folder: (folder / "manifest.json").write_text("{"), "expected the manifest of a run, found other data"),
        (
            lambda folder: (folder / "manifest.json").write_text("[]"),
            "expected the manifest of a run, found other data",
        ),
        (lambda folder: (folder / "places.csv").unlink(), "found no places.csv"),
        (break_table, "events.csv: expected a table of a finished run, found other data"),
        (lambda folder: (folder / "events.csv").write_text("a,b\n1,2\n"), "found no column 'scenario'"),
    ],
    ids=["no folder", "no manifest", "half a manifest", "other manifest", "no table", "no text", "other table"],
)
def test_what_is_no_run_is_said_in_a_sentence(run_folder, tmp_path, spoil, said):
    folder = shutil.copytree(run_folder, tmp_path / "spoilt")
    spoil(folder)
    with pytest.raises(GpsecError) as caught:
        load(folder).events  # noqa: B018
    assert said in str(caught.value)
    assert "spoilt" in str(caught.value)


def test_unknown_scenarios_are_named(run):
    with pytest.raises(GpsecError, match=r"no scenario 'town' in this run \(there are: lane\)"):
        run.manifest("town")


def test_parquet_files_hold_what_the_csv_files_do(run_folder, tmp_path):
    run = load(shutil.copytree(run_folder, tmp_path / "typed"))
    write_parquet(run)
    for name in LARGE_TABLES:
        pd.testing.assert_frame_equal(pd.read_parquet(run.folder / f"{name}.parquet"), getattr(run, name))


FORMULAS = ("=1+1", "+1+1", "-a", "@sum(a1)", "-1|x")


def cells(path):
    return pd.read_csv(path, dtype=str, keep_default_na=False, encoding="utf-8-sig")


def test_no_cell_for_a_spreadsheet_is_a_formula(tmp_path):
    folder = write_run(tmp_path / "run", log=False)
    for name in ("events", "vehicles"):
        table = cells(folder / f"{name}.csv")
        table["vehicle_id"] = table["vehicle_id"].replace(dict(zip("bcdef", FORMULAS, strict=True)))
        table["rmse_xy_m"] = "-1.5e-05"
        table.to_csv(folder / f"{name}.csv", index=False)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert [path.name for path in write_spreadsheets(load(folder))] == [f"{name}.spreadsheet.csv" for name in TABLES]
    written = cells(folder / "vehicles.spreadsheet.csv")
    assert {f"'{formula}" for formula in FORMULAS} < set(written["vehicle_id"])
    assert not set(FORMULAS) & set(written["vehicle_id"])
    # Numbers, and all other texts, are as they were; so are the tables themselves.
    assert written.drop(columns="vehicle_id").equals(table.drop(columns="vehicle_id"))
    assert cells(folder / "places.spreadsheet.csv").equals(cells(folder / "places.csv"))
    assert {name: (folder / name).read_bytes() for name in before} == before


def test_tables_for_a_spreadsheet_are_asked_for(run_folder, tmp_path, capsys):
    folder = shutil.copytree(run_folder, tmp_path / "asked")
    assert cli.main(["report", str(folder), "--spreadsheet"]) == 0
    assert str(folder / "safety.spreadsheet.csv") in capsys.readouterr().out.splitlines()
