"""Pictures and videos that can be read, and those that cannot."""

import cv2
import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.detect import detect_lanes
from gpsec.imaging.pictures.frames import open_frames

from .roads import road, view


@pytest.fixture
def folder(tmp_path):
    for number, offset in enumerate((0.0, 0.2, -0.1)):
        cv2.imwrite(str(tmp_path / f"{number}.png"), view(road(), offset))
    return tmp_path


def test_a_table_and_pictures_of_what_was_found(folder, tmp_path):
    (out := tmp_path / "out").mkdir()
    found = detect_lanes(open_frames(folder, 20.0), RoadCamera(), out, width_m=3.5, overlay="pictures")
    assert (found.pictures, found.lanes) == (3, 3)
    lines = (out / "lanes.csv").read_text().splitlines()
    assert lines[0] == "frame,t_s,c0_m,c1,c2_per_m,c3_per_m2,width_m,sigma_m,valid"
    assert lines[2].startswith("1.png,0.050,-0.")
    assert float(lines[2].split(",")[2]) == pytest.approx(-0.2, abs=0.02)
    assert sorted(path.name for path in out.glob("*.png")) == ["lane-0.png", "lane-1.png", "lane-2.png"]


def test_a_picture_without_a_lane_has_empty_cells(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), view(road(paint=False), 0.0))
    (out := tmp_path / "out").mkdir()
    assert detect_lanes(open_frames(tmp_path), RoadCamera(), out).lanes == 0
    assert (out / "lanes.csv").read_text().splitlines()[1] == "a.png,0.000,,,,,,,0"


def test_a_video_is_read_at_its_rate(folder, tmp_path):
    path = tmp_path / "v.mp4"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 25.0, (640, 360))
    for number in range(4):
        video.write(cv2.imread(str(folder / f"{number % 3}.png")))
    video.release()
    frames = open_frames(path)
    assert frames.rate_hz == 25.0
    assert [shot.time_s for shot in frames.shots(RoadCamera())] == [0.0, 0.04, 0.08, 0.12]


def read_all(path):
    return list(open_frames(path).shots(RoadCamera()))


def test_what_cannot_be_read_is_said_in_a_sentence(folder, tmp_path):
    with pytest.raises(GpsecError, match="no such folder or video"):
        open_frames(tmp_path / "nothing")
    (empty := tmp_path / "empty").mkdir()
    with pytest.raises(GpsecError, match=r"expected pictures .*, found none"):
        open_frames(empty)
    (tmp_path / "v.mp4").write_bytes(b"no video")
    with pytest.raises(GpsecError, match="expected a video with frames, found none"):
        read_all(tmp_path / "v.mp4")
    (folder / "3.png").write_bytes(b"no picture")
    with pytest.raises(GpsecError, match=r"3\.png: expected a picture, found a file that cannot be read"):
        read_all(folder)
    cv2.imwrite(str(folder / "3.png"), np.zeros((20, 30, 3), np.uint8))
    with pytest.raises(GpsecError, match=r"3\.png: expected 640 x 360 pixels as in the calibration, found 30 x 20"):
        read_all(folder)


def test_times_that_run_backwards_are_refused(folder):
    (folder / "truth.csv").write_text("frame,t_s,speed_mps,yaw_rate_rps\n0.png,2,1,0\n1.png,1,1,0\n")
    with pytest.raises(GpsecError, match=r"truth\.csv: row 3: t_s: expected more than 2, found 1"):
        read_all(folder)


def test_memory_needs_to_know_how_the_vehicle_moved(folder, tmp_path):
    (out := tmp_path / "out").mkdir()
    with pytest.raises(GpsecError, match="--memory takes frames"):
        detect_lanes(open_frames(folder), RoadCamera(), out, memory_m=15.0)
