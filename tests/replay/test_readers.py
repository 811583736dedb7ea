"""Each reader gives the drive that was written; what cannot be one is refused in a sentence."""

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.replay.columns import read_csv_log
from gpsec.replay.comma2k19 import read_comma2k19
from gpsec.replay.errors import fix_errors, speed_errors, yaw_rate_errors
from gpsec.replay.fcd import read_clock, steps
from gpsec.replay.readers import choose_reader, content_digest, read_drive

from .logs import Way, comma_segment, csv_log, table, way


def test_csv_gives_what_was_written(tmp_path):
    log = read_drive(csv_log(tmp_path), "csv")
    drive = way()
    assert log.pose.numbers[:, 0] == pytest.approx(drive.east_m)
    assert log.fixes.time_s == pytest.approx(drive.time_s[::2])
    assert log.speed.numbers[:, 0].mean() == pytest.approx(1.01 * 15.0, abs=0.01)
    assert log.heading is None
    assert log.lane is None


def test_csv_takes_degrees_compass_and_ages(tmp_path):
    columns = table()
    yaw = columns.pop("yaw_rad").to_numpy()
    columns["yaw_compass_deg"] = 90.0 - np.degrees(yaw)
    columns["heading_deg"] = np.degrees(yaw)
    columns["yaw_rate_dps"] = np.degrees(columns.pop("yaw_rate_rps"))
    columns["fix_age_s"] = 0.0
    log = read_drive(csv_log(tmp_path, columns), "csv")
    assert np.cos(log.pose.numbers[:, 2] - yaw) == pytest.approx(1.0)
    assert log.heading.numbers[:, 0] == pytest.approx(yaw)
    assert log.yaw_rate.numbers[:, 0] == pytest.approx(table()["yaw_rate_rps"].to_numpy())


def test_csv_on_the_earth_has_metres_around_its_first_position(tmp_path):
    columns = table()
    for prefix in ("", "fix_"):
        # A degree of latitude has 111.2 km on a sphere of 6371 km; the ellipsoid differs by less than 0.5 %.
        columns[f"{prefix}lat_deg"] = columns.pop(f"{prefix}y_m") / 111_194.9
        columns[f"{prefix}lon_deg"] = columns.pop(f"{prefix}x_m") / 111_194.9
    log = read_drive(csv_log(tmp_path, columns), "csv")
    assert log.projection.startswith("+proj=tmerc")
    assert log.pose.numbers[0, :2] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert log.pose.numbers[-1, 0] == pytest.approx(way().east_m[-1], rel=0.01)


@pytest.mark.parametrize("flat", [False, True])
def test_comma2k19_gives_what_was_written(tmp_path, flat):
    log = read_drive(comma_segment(tmp_path / "40", flat=flat), "comma2k19")
    drive = way()
    assert log.pose.numbers[:, :2] == pytest.approx(np.column_stack([drive.east_m, drive.north_m]), abs=1e-3)
    # The camera looks 1° off the course, which is taken out.
    assert log.pose.numbers[:, 2] == pytest.approx(drive.yaw_rad, abs=np.radians(0.05))
    # Fixes arrive 0.2 s after they were true, and are 0.5 m too far north.
    assert log.fixes.time_s - log.fixes.valid_s == pytest.approx(0.2, abs=1e-6)
    errors = fix_errors(log)
    assert errors.errors[~errors.missing] == pytest.approx(
        np.broadcast_to([0.0, 0.5], (401, 2))[: (~errors.missing).sum()], abs=2e-3
    )
    assert log.yaw_rate.numbers[:, 0] == pytest.approx(drive.yaw_rate_rps)


def test_errors_are_those_that_were_put_in(tmp_path):
    log = read_drive(csv_log(tmp_path), "csv")
    fixes = fix_errors(log)
    assert fixes.rate_hz == pytest.approx(10.0)
    assert not fixes.missing.any()
    assert fixes.errors.mean(axis=0) == pytest.approx([0.4, -0.3], abs=0.003)
    assert fixes.errors.std(axis=0) == pytest.approx([0.01, 0.01], rel=0.15)
    speed, factor = speed_errors(log)
    assert factor == pytest.approx(1.01, abs=0.001)
    # White noise of 0.02 m/s at 20 Hz, over a tenth of a second: two samples and the halves beside them, by trapezoids.
    assert speed.errors.std() == pytest.approx(0.02 / np.sqrt(2.0), rel=0.25)
    assert abs(yaw_rate_errors(log).errors.mean()) < 3e-4


def broken(change):
    def make(folder: Path) -> Path:
        columns = table()
        return csv_log(folder, change(columns))

    return make


def with_cell(name: str, row: int, value: object):
    def change(columns: pd.DataFrame) -> pd.DataFrame:
        columns[name] = columns[name].astype(object)
        columns.loc[row, name] = value
        return columns

    return change


BROKEN = {
    "time runs backwards": (
        with_cell("t_s", 100, 1.0),
        r"pose: sample 101: expected times that ascend, found 1\.000 s after 4\.950 s",
    ),
    "not a number": (with_cell("fix_x_m", 4, "nan"), r"row 6, fix_x_m: expected a number, found 'nan'"),
    "words": (with_cell("speed_mps", 4, "fast"), r"row 6, speed_mps: expected a number, found 'fast'"),
    "no time": (with_cell("t_s", 5, ""), r"row 7, t_s: expected a time, found an empty cell"),
    "a gap": (
        lambda c: c[(c["t_s"] < 10.0) | (c["t_s"] > 13.0)],
        r"pose: expected gaps of at most 1 s, found one of 3\.1\d s behind 9\.95 s",
    ),
    "degrees for radians": (
        lambda c: c.assign(yaw_rad=np.degrees(c["yaw_rad"])),
        r"row \d+, yaw_rad: expected -6\.283 to 6\.283, in radians; degrees have a column of their own",
    ),
    "radians for degrees": (lambda c: c.rename(columns={"yaw_rad": "yaw_deg"}), r"pose: expected a yaw in radians"),
    "a rate in degrees": (
        lambda c: c.assign(yaw_rate_rps=np.degrees(c["yaw_rate_rps"])),
        r"yaw_rate: expected radians a second, .* found values that are 5\d\.\d times",
    ),
    "a rate the other way": (
        lambda c: c.assign(yaw_rate_rps=-c["yaw_rate_rps"]),
        r"yaw_rate: expected radians a second, counter-clockwise",
    ),
    "km/h": (
        lambda c: c.assign(speed_mps=3.6 * c["speed_mps"]),
        r"speed: expected metres a second, found values that are 3\.6\d times",
    ),
    "another frame": (
        lambda c: c.assign(fix_x_m=c["fix_y_m"] + 5e5),
        r"fix: expected fixes in the frame of the pose, found them \d+ m away",
    ),
    "an unknown column": (lambda c: c.assign(fix_xm=1.0), r"unknown column 'fix_xm': did you mean 'fix_x_m'\?"),
    "half a position": (lambda c: c.drop(columns="y_m"), r"y_m: expected this column beside its partner, found none"),
    "no yaw": (lambda c: c.drop(columns="yaw_rad"), r"expected one of the columns yaw_rad, yaw_deg, yaw_compass_deg"),
    "too short": (lambda c: c[c["t_s"] < 5.0], r"pose: expected a drive of 20 to 86400 s, found 5\.0 s|found 4\.9"),
    "nothing": (lambda c: c[:0], r"expected rows below the header, found none"),
    "standing": (lambda c: c.assign(x_m=0.0, y_m=0.0), r"pose: expected a way of at least 50 m, found 0\.0 m"),
    "a jump": (
        lambda c: c.assign(x_m=c["x_m"] + 100.0 * (c["t_s"] > 20.0)),
        r"pose: sample \d+: expected a drive, found a jump of 10\d\.\d m",
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_log_that_is_none_is_refused_in_a_sentence(tmp_path, name):
    change, said = BROKEN[name]
    with pytest.raises(GpsecError, match=said) as refused:
        read_drive(broken(change)(tmp_path), "csv")
    assert str(refused.value).startswith(str(tmp_path / "drive.csv"))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("wrong", [np.degrees, np.negative])
def test_a_rate_is_compared_in_a_steady_turn_too(tmp_path, wrong):
    straight = way()
    yaw = 0.04 * straight.time_s
    round_it = Way(straight.time_s, 375 * np.sin(yaw), -375 * np.cos(yaw), yaw, straight.speed_mps, 0.0 * yaw + 0.04)
    columns = table(round_it)
    read_drive(csv_log(tmp_path, columns), "csv")
    columns["yaw_rate_rps"] = wrong(columns["yaw_rate_rps"])
    with pytest.raises(GpsecError, match=r"yaw_rate: expected radians a second, .* rad/s off the pose on average"):
        read_drive(csv_log(tmp_path, columns), "csv")


def test_a_segment_that_lacks_an_array_or_holds_something_else_is_refused(tmp_path):
    folder = comma_segment(tmp_path / "40")
    (folder / "processed_log/CAN/speed/t").unlink()
    with pytest.raises(GpsecError, match="processed_log/CAN/speed/t: expected this array"):
        read_comma2k19(folder)
    (folder / "processed_log/CAN/speed/t").write_bytes(b"no array")
    with pytest.raises(GpsecError, match="expected an array of numpy, found a broken file"):
        read_comma2k19(folder)


FCD = """<fcd-export>
<timestep time="0.00"><vehicle id="a" x="1" y="2" angle="90" type="car" speed="3" pos="1" lane="ab_0"/></timestep>
<timestep time="0.10"><vehicle id="a" x="1.3" y="2" angle="90" type="car" speed="3" pos="1.3" lane="ab_0"/></timestep>
</fcd-export>"""


def test_fcd_gives_steps(tmp_path):
    file = tmp_path / "fcd.xml.gz"
    file.write_bytes(gzip.compress(FCD.encode()))
    (_, _), (time_s, seen) = list(steps(file))
    assert time_s == 0.1
    assert (seen[0].vehicle_id, seen[0].x, seen[0].lane) == ("a", 1.3, "ab_0")
    assert read_clock(file).step_s == 0.1


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<fcd-export>", "<net>", "found <net>|cannot be read"),
        ('x="1.3"', 'x="nan"', "vehicle 'a': x: expected a number, found 'nan'"),
        (' lane="ab_0"', "", "vehicle 'a': expected the attribute lane"),
        ('time="0.10"', 'time="1.00"', r"expected steps of 0\.001 to 0\.2 s, .* found 1 s; run SUMO"),
        ("</fcd-export>", "", "XML that cannot be read"),
    ],
)
def test_fcd_that_is_none_is_refused(tmp_path, old, new, said):
    file = tmp_path / "fcd.xml"
    file.write_text(FCD.replace(old, new))
    with pytest.raises(GpsecError, match=said):
        list(steps(file)) and read_clock(file)


def test_readers_are_chosen_by_what_is_there(tmp_path):
    assert choose_reader(csv_log(tmp_path), None) == "csv"
    assert choose_reader(comma_segment(tmp_path / "40"), None) == "comma2k19"
    other = tmp_path / "drive.bag"
    other.write_text("")
    with pytest.raises(GpsecError, match=r"expected a segment of comma2k19, a \.csv, or SUMO's FCD output"):
        choose_reader(other, None)
    with pytest.raises(GpsecError, match="--reader cvs: unknown reader: did you mean 'csv'"):
        choose_reader(other, "cvs")
    with pytest.raises(GpsecError, match="no such log"):
        choose_reader(tmp_path / "nothing.csv", None)


def test_a_log_is_known_by_its_content(tmp_path):
    file = csv_log(tmp_path)
    before = content_digest(file)
    assert content_digest(file) == before
    csv_log(tmp_path, table(seed=2))
    assert content_digest(file) != before


def test_empty_cells_are_no_samples(tmp_path):
    columns = table()
    columns.loc[5:9, "speed_mps"] = np.nan
    assert len(read_csv_log(csv_log(tmp_path, columns)).speed.time_s) == len(columns) - 5
