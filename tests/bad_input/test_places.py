"""Output folders, models and caches that are not as they should be: nothing is lost, nothing half written."""

import shutil
from pathlib import Path

import pytest

import gpsec
from gpsec.core.errors import GpsecError
from gpsec.detection.models import build_detectors, load_models
from gpsec.hdmap.map import load_map
from gpsec.running.folders import resolved

LEARNED = ("isolation_forest", "lstm_glr")


def test_links_in_a_circle(here: Path) -> None:
    (here / "out").symlink_to("out")
    with pytest.raises(GpsecError, match="out: no results can be written there: Symlink loop"):
        resolved(Path("out"))


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"format": 1, "models": {"carla": []}}', b"\xff\xfe"])
def test_damaged_thresholds(here: Path, content: bytes) -> None:
    shutil.copytree(Path(gpsec.__file__).parent / "models", here / "models")
    (here / "models" / "thresholds.json").write_bytes(content)
    with pytest.raises(GpsecError, match=r"models/thresholds\.json: .*gpsec train"):
        load_models(here / "models")


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_damaged_arrays(here: Path, share: float) -> None:
    shutil.copytree(Path(gpsec.__file__).parent / "models", here / "models")
    arrays = here / "models" / "carla-tracked.npz"
    arrays.write_bytes(arrays.read_bytes()[: int(share * arrays.stat().st_size)])
    with pytest.raises(GpsecError, match=r"models/carla-tracked\.npz: damaged"):
        build_detectors(LEARNED, ("carla",), "tracked", load_models(here / "models"))


def test_damaged_map_is_made_again(here: Path, grid: str) -> None:
    net = here / "grid.net.xml"
    net.write_text(grid)
    whole = load_map(net, (5.0,), here / "cache")
    for array in (here / "cache" / "maps").rglob("MapArrays.x0_m.npy"):
        array.write_bytes(array.read_bytes()[:200])
    again = load_map(net, (5.0,), here / "cache")
    assert again.lanes.x0_m.tobytes() == whole.lanes.x0_m.tobytes()
    (array,) = (here / "cache" / "maps").rglob("MapArrays.x0_m.npy")
    assert array.stat().st_size > 200
