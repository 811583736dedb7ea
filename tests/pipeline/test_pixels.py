"""`fleet.camera.source = "image"`: some vehicles' lanes come from pictures, the others do as they did."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.core.threads import Threads
from gpsec.pipeline.build import lay_ground
from gpsec.pipeline.pixels import PixelCameras
from gpsec.scenario import Scenario
from gpsec.scenario.load import changed
from gpsec.scenario.overrides import parse_set
from gpsec.traffic.source import Departure

from .conftest import Traffic

LOGGED = ("log_steps=true", 'detection.detectors=["chi_square","cusum"]', "defences=[]", "duration_s=15")
EVERYBODY = "fleet.camera.image_vehicles"
Go = Callable[[Scenario], Path]


def with_sets(scenario: Scenario, *sets: str) -> Scenario:
    return changed(scenario, [parse_set(text) for text in sets])


def pictured(scenario: Scenario, names: list[str], *sets: str) -> Scenario:
    return with_sets(scenario, 'fleet.camera.source="image"', f"{EVERYBODY}={json.dumps(names)}", *LOGGED, *sets)


@pytest.fixture
def names(traffic: Traffic) -> list[str]:
    """Three vehicles that are on the road for long."""
    recording = traffic.recording
    return [str(name) for name in recording.vehicle_id[:3]]


def steps_of(folder: Path) -> pd.DataFrame:
    steps = pd.read_parquet(folder / "steps.parquet")
    return steps[steps["plan"] == "none"].reset_index(drop=True)


def test_named_vehicles_see_pictures_and_the_others_do_as_they_did(
    town: Scenario, traffic: Traffic, names: list[str], replay: Callable[[Traffic], None], go: Go
) -> None:
    replay(traffic)
    without, with_pixels = go(with_sets(town, *LOGGED)), go(pictured(town, names))
    stated = json.loads((with_pixels / "manifest.json").read_text())
    assert set(stated["pixels"]["vehicles"]) == set(names)
    assert stated["stages_s"]["pictures"] > 0.0
    assert any("weather good" in note and names[0] in note for note in stated["notes"])
    assert json.loads((without / "manifest.json").read_text())["pixels"] == {}
    before, after = steps_of(without), steps_of(with_pixels)
    of_them = after["vehicle_id"].isin(names)
    assert of_them.any()
    pd.testing.assert_frame_equal(before[~of_them], after[~of_them])
    # What the camera saw differs from what the profile's would have said; the traffic is the same.
    seen, said = after.loc[of_them, "camera_offset_m"], before.loc[of_them, "camera_offset_m"]
    both = (seen.notna() & said.notna()).to_numpy()
    assert both.sum() > 50
    assert (seen[both] != said[both]).all()
    assert np.median(np.abs(seen[both] - said[both])) < 0.3
    pd.testing.assert_series_equal(before.loc[of_them, "x_m"], after.loc[of_them, "x_m"])
    taken = stated["pixels"]["vehicles"]
    assert sum(one["lanes"] for one in taken.values()) == seen.notna().sum()


def test_two_threads_give_the_same_bytes(
    town: Scenario,
    traffic: Traffic,
    names: list[str],
    replay: Callable[[Traffic], None],
    go: Go,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    replay(traffic)
    monkeypatch.setattr(Threads, "MIN_ROWS", 8)
    memory = "fleet.camera.image_memory_m=15"
    one, two = (go(pictured(town, names, memory, f"threads={threads}")) for threads in (1, 2))
    pd.testing.assert_frame_equal(steps_of(one), steps_of(two))
    assert (one / "vehicles.csv").read_bytes() == (two / "vehicles.csv").read_bytes()


def test_both_engines_are_given_the_same_pictures(
    town: Scenario, traffic: Traffic, names: list[str], replay: Callable[[Traffic], None], go: Go
) -> None:
    replay(traffic)
    batched, reference = (
        steps_of(go(pictured(town, names, f'engine="{engine}"', "duration_s=8"))) for engine in ("batched", "reference")
    )
    pd.testing.assert_series_equal(batched["camera_offset_m"], reference["camera_offset_m"])
    pd.testing.assert_frame_equal(batched.filter(like="residual"), reference.filter(like="residual"), atol=1e-9)


def departure(name: str) -> Departure:
    return Departure(0, name, "car", "passenger", 4.5, 1.8, 0.0, 0.0, None, None, sumo_id=name.partition("#")[0])


def test_a_share_is_drawn_by_the_vehicle_alone(town: Scenario) -> None:
    ground = lay_ground(with_sets(town, 'fleet.camera.source="image"', "fleet.camera.image_share=0.25"))
    cameras = ground.pixels
    assert isinstance(cameras, PixelCameras)
    drawn = [cameras.sees(departure(f"v{number}")) for number in range(4000)]
    assert abs(np.mean(drawn) - 0.25) < 0.03
    again = [cameras.sees(departure(f"v{number}#2")) for number in range(4000)]
    assert again == drawn
    more = replace(cameras, share=0.5)
    assert all(more.sees(departure(f"v{number}")) for number, one in enumerate(drawn) if one)


def test_who_is_not_there_is_named(town: Scenario, traffic: Traffic, replay: Callable[[Traffic], None], go: Go) -> None:
    replay(traffic)
    folder = go(pictured(town, ["nobody"], "duration_s=2"))
    notes = json.loads((folder / "manifest.json").read_text())["notes"]
    assert "no pictures of nobody: no such vehicle of the fleet in this run" in notes


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        (["fleet.camera.source=image"], "takes an image_share above 0, or image_vehicles, found neither"),
        (["fleet.camera.image_share=0.1"], "take source = 'image', found 'profile'"),
        (["fleet.camera.image_weather=fog"], "unknown image_weather 'fog'"),
        (["fleet.camera.source=image", "fleet.camera.image_share=2"], "image_share"),
    ],
)
def test_what_cannot_be_meant_is_said(town: Scenario, sets: list[str], said: str) -> None:
    with pytest.raises(GpsecError, match=said):
        with_sets(town, *sets)


def test_without_the_extra_a_sentence_names_it(repository: Path, tmp_path: Path) -> None:
    (tmp_path / "cv2.py").write_text("raise ImportError('hidden by a test')")
    asked = ["--set", "fleet.camera.source=image", "--set", "fleet.camera.image_share=0.1"]
    command = [sys.executable, "-m", "gpsec", "run", str(repository / "scenarios" / "town"), *asked]
    where = os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{repository}"}
    done = subprocess.run(
        [*command, "--out", str(tmp_path / "r")], capture_output=True, text=True, check=False, env=where
    )
    assert done.returncode == 2
    assert "pictures need the extra 'image' (pip install 'gpsec[image]')" in done.stderr
    assert not (tmp_path / "r").exists()


def test_a_run_without_pictures_imports_no_image_processing(repository: Path, tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from gpsec.pipeline.build import lay_ground;"
        "from gpsec.scenario import load_scenario; from gpsec.pipeline.fingerprint import fingerprint;"
        f"s = load_scenario({str(repository / 'scenarios' / 'town')!r}); lay_ground(s); fingerprint(s);"
        "print(sorted(n for n in sys.modules if n == 'cv2' or n.startswith('gpsec.imaging')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "cv2" not in done.stdout
    assert "gpsec.imaging.pictures.render" not in done.stdout
