"""Calibration files, and calibration by pictures of which the camera is known."""

import json
from dataclasses import asdict, replace

import cv2
import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.imaging.pictures.calibrate import lens_of, mounted
from gpsec.imaging.pictures.calibration import read_calibration, write_calibration
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.frames import Shot

from .roads import road, view


def test_a_file_is_read_as_it_was_written(tmp_path):
    camera = RoadCamera(distortion=(0.1, -0.2, 0.0, 0.01, 0.0), yaw_deg=1.5)
    write_calibration(camera, tmp_path / "c.json")
    assert read_calibration(tmp_path / "c.json") == camera


WRONG = {
    "expected the key 'fx', found none": lambda keys: {k: v for k, v in keys.items() if k != "fx"},
    "unknown key 'fxx'; did you mean 'fx'": lambda keys: keys | {"fxx": 1.0},
    "z_m: expected 0.2 to 10, found -1": lambda keys: keys | {"z_m": -1},
    "width: expected a whole number": lambda keys: keys | {"width": 640.5},
    "pitch_deg: expected a number": lambda keys: keys | {"pitch_deg": "3"},
    "fy: expected a number, found nan": lambda keys: keys | {"fy": float("nan")},
    "distortion: expected five numbers": lambda keys: keys | {"distortion": [0.0]},
    "hood_row: expected 1 to 360": lambda keys: keys | {"hood_row": 500},
    "expected a JSON object": lambda keys: [keys],
}


@pytest.mark.parametrize("said", WRONG)
def test_a_wrong_file_is_refused_by_its_key(said, tmp_path):
    (tmp_path / "c.json").write_text(json.dumps(WRONG[said](asdict(RoadCamera()))))
    with pytest.raises(GpsecError, match=said):
        read_calibration(tmp_path / "c.json")


def test_no_file_and_none_that_is_json(tmp_path):
    with pytest.raises(GpsecError, match="no such calibration file"):
        read_calibration(tmp_path / "c.json")
    (tmp_path / "c.json").write_bytes(b"\xff{")
    with pytest.raises(GpsecError, match="expected a calibration"):
        read_calibration(tmp_path / "c.json")


def board_from(camera, turn):
    """The picture of a chessboard of 7 x 5 inner corners, turned about two axes, 0.6 m in front of a camera."""
    flat = np.full((360, 480), 255, np.uint8)
    for row in range(6):
        for column in range(8):
            if (row + column) % 2:
                flat[30 + 50 * row : 80 + 50 * row, 40 + 50 * column : 90 + 50 * column] = 0
    rotation, _ = cv2.Rodrigues(np.array(turn))
    corners = np.array([[0, 0], [479, 0], [479, 359], [0, 359]], np.float32)
    scene = (np.column_stack([corners / 1000.0 - [0.24, 0.18], np.zeros(4)]) @ rotation.T) + [0.0, 0.0, 0.6]
    pixels = camera.fx * scene[:, :2] / scene[:, 2:] + [camera.cx, camera.cy]
    mapping = cv2.getPerspectiveTransform(corners, pixels.astype(np.float32))
    grey = cv2.warpPerspective(flat, mapping, (camera.width, camera.height), borderValue=200)
    return cv2.cvtColor(cv2.GaussianBlur(grey, (3, 3), 0.0), cv2.COLOR_GRAY2BGR)


def test_boards_give_the_focal_length():
    camera = RoadCamera(fx=600.0, fy=600.0)
    turns = [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, 0.5, 0.1), (-0.4, 0.3, 0.0), (0.3, -0.5, 0.2)]
    shots = [Shot(str(turn), 0.0, board_from(camera, turn), None) for turn in turns]
    shots.append(Shot("grey", 0.0, np.full((360, 640, 3), 128, np.uint8), None))
    lens = lens_of(shots, (7, 5))
    assert lens.boards == 5
    assert lens.left_out == ["grey"]
    assert lens.camera.fx == pytest.approx(600.0, rel=0.02)
    with pytest.raises(GpsecError, match="expected at least 3 pictures"):
        lens_of(shots[-1:], (7, 5))


def test_straight_frames_give_pitch_yaw_and_height():
    true = RoadCamera(pitch_deg=4.2, yaw_deg=-1.3, z_m=1.45)
    shots = [Shot(str(offset), 0.0, view(road(3.7), offset, camera=true), None) for offset in (-0.2, 0.1)]
    found = mounted(replace(true, pitch_deg=0.0, yaw_deg=0.0, z_m=1.3), shots, 3.7)
    assert found.pitch_deg == pytest.approx(4.2, abs=0.1)
    assert found.yaw_deg == pytest.approx(-1.3, abs=0.1)
    assert found.z_m == pytest.approx(1.45, abs=0.02)


def test_frames_without_a_lane_calibrate_nothing():
    shots = [Shot("empty", 0.0, view(road(paint=False), 0.0), None)]
    with pytest.raises(GpsecError, match="--straight: expected frames of a straight lane"):
        mounted(RoadCamera(), shots, 3.7)
