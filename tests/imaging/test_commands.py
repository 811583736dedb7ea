"""From traffic to pictures, lanes, an error table and tapes, by the command line."""

import csv

import numpy as np
import pytest

from gpsec.cli import main
from gpsec.types.tapes import read_tape


@pytest.fixture(scope="module")
def folder(repository, tmp_path_factory):
    return tmp_path_factory.mktemp("image")


@pytest.fixture(scope="module")
def measured(repository, folder):
    command = ["image", "measure", str(repository / "scenarios" / "mountain"), "--from", "20", "--to", "31"]
    command += ["--weather", "noiseless", "--extrinsics-deg", "0", "--vehicles", "2", "--out", str(folder / "m")]
    assert main(command) == 0
    return command


def test_the_errors_of_an_exact_camera_are_small(measured, folder):
    with (folder / "m" / "errors.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {(row["mode"], row["place"]) for row in rows} >= {("single", "all"), ("memory", "all")}
    single = next(row for row in rows if (row["mode"], row["place"]) == ("single", "all"))
    assert int(single["pictures"]) >= 200
    assert float(single["c0_mad_m"]) < 0.15
    assert float(single["c0_mad_low_m"]) <= float(single["c0_mad_m"]) <= float(single["c0_mad_high_m"])
    assert (folder / "m" / "errors.png").is_file()


def test_a_tape_is_of_what_was_measured(measured, folder):
    tape, _ = read_tape(folder / "m" / "rendered-noiseless.npz")
    assert tape.rate_hz == pytest.approx(10.0)
    assert tape.provenance["scenarios"] == ["mountain"]
    ends = [*tape.piece[1:].tolist(), len(tape.missing)]
    for first, last in zip(tape.piece.tolist(), ends, strict=True):
        found = tape.errors[first:last][~tape.missing[first:last]]
        np.testing.assert_allclose(np.median(found, axis=0), 0.0, atol=1e-4)


def test_what_was_measured_is_not_measured_again(measured, folder, monkeypatch):
    from gpsec.imaging.filming.measure import Campaign

    before = (folder / "m" / "errors.csv").read_bytes()
    monkeypatch.delattr(Campaign, "_drive")
    assert main(measured) == 0
    assert (folder / "m" / "errors.csv").read_bytes() == before


def test_frames_are_rendered_and_their_lanes_found(repository, folder, capsys):
    scenario = str(repository / "scenarios" / "mountain")
    window = ["--from", "20", "--to", "20.5", "--out", str(folder / "f")]
    assert main(["image", "render", scenario, "--vehicle", "nobody", *window]) == 2
    said = capsys.readouterr().err
    assert "'nobody' is not on the road from 20 to 20.5 s" in said
    assert not (folder / "f").exists()
    vehicle = said.partition("known: ")[2].partition(",")[0]
    assert main(["image", "render", scenario, "--vehicle", vehicle, *window]) == 0
    calibration = str(folder / "f" / "calibration.json")
    found = ["image", "detect", str(folder / "f"), "--calibration", calibration, "--out", str(folder / "l")]
    assert main([*found, "--memory", "15"]) == 0
    assert len((folder / "l" / "lanes.csv").read_text().splitlines()) == 7
    assert main(found) == 2
    assert "expected a folder that is not there yet or empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["render", "mountain", "--vehicle", "a", "--weather", "fog", "--out", "x"], "unknown weather 'fog'"),
        (["render", "mountain", "--vehicle", "a", "--from", "5", "--to", "4", "--out", "x"], "--to: expected more"),
        (["calibrate"], "expected --boards, or --straight with --focal-px"),
        (["calibrate", "--boards", ".", "--corners", "9"], "--corners: expected two numbers"),
        (["detect", ".", "--calibration", "none.json"], "none.json: no such calibration file"),
        (["detect", ".", "--calibration", "none.json", "--overlay", "all"], "--overlay: expected none, pictures"),
    ],
)
def test_what_cannot_be_meant_is_said(arguments, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.png").write_bytes(b"")
    assert main(["image", *arguments]) == 2
    assert said in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]
