"""Output folders, models and caches that are not as they should be: nothing is lost, nothing half written."""

import shutil
from pathlib import Path

import pytest

import gpsec
from gpsec.console.folders import publish, resolved, workshop
from gpsec.detection.models import build_detectors, load
from gpsec.errors import GpsecError
from gpsec.hdmap.map import load_map

LEARNED = ("isolation_forest", "lstm")


def made(here: Path) -> Path:
    folder = here / "work" / "made"
    folder.mkdir(parents=True)
    for name in ("manifest.json", "events.csv"):
        (folder / name).write_text("new")
    return folder


def test_replacing_a_run_keeps_what_no_run_wrote(here: Path) -> None:
    out = here / "out"
    out.mkdir()
    former = ("manifest.json", "steps.parquet", "report.html", "trace-car.html", "places.geojson", "map-a.geojson")
    for name in (*former, "mine.csv", "notes.json", "page.html"):
        (out / name).write_text("old")
    publish(made(here), out, here / "work" / "former", overwrite=True)
    assert {path.name: path.read_text() for path in out.iterdir()} == {
        **dict.fromkeys(("manifest.json", "events.csv"), "new"),
        **dict.fromkeys(("mine.csv", "notes.json", "page.html"), "old"),
    }


def test_results_that_cannot_be_put_into_place_are_beside_it(here: Path) -> None:
    (here / "out").mkdir()
    (here / "out" / "thesis.tex").write_text("appeared during the run")
    with pytest.raises(GpsecError, match=r"found files that no run wrote.*the results of this run are in .*/out-2\)$"):
        publish(made(here), here / "out", here / "work" / "former", overwrite=True)
    assert (here / "out-2" / "events.csv").read_text() == "new"
    assert [path.name for path in (here / "out").iterdir()] == ["thesis.tex"]


def test_folder_that_somebody_stands_in_stays_the_same(here: Path) -> None:
    (here / "out").mkdir()
    before = (here / "out").stat().st_ino
    publish(made(here), here / "out", here / "work" / "former", overwrite=False)
    assert (here / "out").stat().st_ino == before
    assert (here / "out" / "manifest.json").exists()


def test_links_in_a_circle(here: Path) -> None:
    (here / "out").symlink_to("out")
    with pytest.raises(GpsecError, match="out: no results can be written there: Symlink loop"):
        resolved(Path("out"))


def test_no_empty_folder_is_left(here: Path) -> None:
    with workshop(here / "a" / "b" / "out", resume=False) as work:
        assert work.folder.is_dir()
    assert list(here.iterdir()) == []


def test_two_runs_into_one_folder(here: Path) -> None:
    with (
        workshop(here / "out", resume=False),
        pytest.raises(GpsecError, match="out: another run is being written there"),
        workshop(here / "out", resume=True),
    ):
        pass
    assert list(here.iterdir()) == []


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"format": 1, "models": {"carla": []}}', b"\xff\xfe"])
def test_damaged_thresholds(here: Path, content: bytes) -> None:
    shutil.copytree(Path(gpsec.__file__).parent / "models", here / "models")
    (here / "models" / "thresholds.json").write_bytes(content)
    with pytest.raises(GpsecError, match=r"models/thresholds\.json: .*gpsec train"):
        load(here / "models")


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_damaged_arrays(here: Path, share: float) -> None:
    shutil.copytree(Path(gpsec.__file__).parent / "models", here / "models")
    arrays = here / "models" / "carla-tracked.npz"
    arrays.write_bytes(arrays.read_bytes()[: int(share * arrays.stat().st_size)])
    with pytest.raises(GpsecError, match=r"models/carla-tracked\.npz: damaged"):
        build_detectors(LEARNED, ("carla",), "tracked", load(here / "models"))


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
