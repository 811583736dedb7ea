"""Pictures side by side, and short films of what was found in them."""

from pathlib import Path

import numpy as np
import pytest

from gpsec.cli import main
from gpsec.core.errors import GpsecError
from gpsec.imaging.pictures.calibration import write_calibration
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.detect import detect_lanes
from gpsec.imaging.pictures.figure import Panel, write_figure
from gpsec.imaging.pictures.frames import open_frames, read_picture
from gpsec.imaging.pictures.opencv import opencv

from .roads import road, view


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("frames")
    ground = road()
    for number in range(6):
        opencv().imwrite(str(folder / f"{number:05d}.png"), view(ground, 0.1 * number))
    write_calibration(RoadCamera(), folder / "calibration.json")
    return folder


def test_a_figure_has_its_pictures_in_rows_with_their_lanes(frames: Path, tmp_path: Path) -> None:
    names = [str(frames / f"{number:05d}.png") for number in range(3)]
    out = tmp_path / "figure.png"
    assert main(["image", "figure", *names, "--out", str(out), "--width", "320", "--lane-width", "3.5"]) == 0
    figure = read_picture(out)
    assert figure.shape == (2 * (180 + 26), 2 * 320 + 6, 3)
    # The lane is drawn into the first one: its centre is vermilion, which the road is not anywhere.
    first = figure[:180, :320].astype(int)
    assert ((first[..., 2] - first[..., 0]) > 120).sum() > 50
    assert (figure[206:386, 326:] == 255).all()


def test_a_panel_is_named_by_its_title_or_its_folder() -> None:
    assert Panel.of("rain=a/b.png") == Panel("rain", Path("a/b.png"))
    assert Panel.of("night/00001.png").title == "night"


def test_what_cannot_be_drawn_is_said(frames: Path, tmp_path: Path) -> None:
    panel = Panel.of(str(frames / "00000.png"))
    with pytest.raises(GpsecError, match="expected a name that ends in"):
        write_figure([panel], tmp_path / "figure.pdf", columns=1, width=100)
    small = tmp_path / "small.png"
    opencv().imwrite(str(small), np.zeros((90, 160, 3), np.uint8))
    with pytest.raises(GpsecError, match=r"calibration\.json: no such calibration file"):
        write_figure([Panel.of(str(small))], tmp_path / "figure.png", columns=1, width=100)
    write_calibration(RoadCamera(), tmp_path / "calibration.json")
    with pytest.raises(GpsecError, match=r"expected 640 x 360 pixels .* beside it, found 160 x 90"):
        write_figure([Panel.of(str(small))], tmp_path / "figure.png", columns=1, width=100)
    assert not (tmp_path / "figure.png").exists()


def test_an_animation_has_five_pictures_a_second(frames: Path, tmp_path: Path) -> None:
    found = detect_lanes(open_frames(frames, 10.0), RoadCamera(), tmp_path, width_m=3.5, overlay="animation")
    assert found.pictures == 6
    read, film = opencv().imreadanimation(str(tmp_path / "lanes.webp"))
    assert read
    assert [frame.shape[:2] for frame in film.frames] == [(225, 400)] * 3
    assert list(film.durations) == [200, 200, 200]
