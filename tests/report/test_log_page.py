"""The page "profile against log"."""

import json
import re
from pathlib import Path

import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.replay.errors import fix_errors
from gpsec.replay.figures import error_table
from gpsec.replay.readers import read_drive
from gpsec.replay.tape import receiver_tape
from gpsec.report.log_page import times_said, write_log_page
from gpsec.report.page import unpacked
from gpsec.sensors.registry import PROFILES
from gpsec.types.tapes import write_tape
from tests.replay.logs import csv_log


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    log = read_drive(csv_log(tmp_path), "csv")
    error_table(log, "drive", PROFILES["consumer"]).to_csv(tmp_path / "errors.csv", index=False)
    write_tape(receiver_tape(fix_errors(log), "log", {}), tmp_path / "gnss.tape.npz")
    return tmp_path


def data(page: Path) -> dict:
    return json.loads(unpacked(re.search(r'id="data">([^<]+)<', page.read_text("utf-8"))[1]))


def test_figures_stand_beside_the_profiles(folder):
    page = write_log_page(folder)
    series = data(page)["figures"]["structure"]["series"]
    log, profile = (next(one for one in series if one["name"] == name) for name in ("log", "profile"))
    # 1 cm of white noise: √2 cm at every lag; consumer wanders smoothly instead, 3 mm in 0.1 s.
    assert log["y"] == pytest.approx([0.0141] * len(log["y"]), rel=0.15)
    assert profile["y"][0] == pytest.approx(0.0032, abs=1e-4)
    east = next(one for one in data(page)["figures"]["time"]["series"] if one["name"] == "east")
    assert pd.Series(east["y"]).mean() == pytest.approx(0.4, abs=0.01)
    assert "profile against log" in page.read_text("utf-8")


def test_what_is_off_by_more_than_two_is_marked():
    assert times_said(0.05, 0.2) == "0.25× ▼"
    assert times_said(-0.9, 0.3) == "3× ▲"
    assert times_said(0.3, 0.2) == "1.5×"
    assert times_said(float("nan"), 0.2) == times_said(0.2, 0.0) == "–"


def test_a_run_without_a_log_has_no_page(tmp_path):
    assert write_log_page(tmp_path) is None


def test_a_table_that_is_none_is_refused(tmp_path):
    (tmp_path / "errors.csv").write_text("scenario,sensor\na,b\n")
    with pytest.raises(GpsecError, match=r"errors\.csv: axis: expected this column, found none"):
        write_log_page(tmp_path)
