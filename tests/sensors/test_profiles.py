import importlib.util
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from gpsec.core.errors import GpsecError
from gpsec.sensors.profiles import Gyro, SensorProfile, residual_sigma_m
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.shipped_tapes import load_tape
from tests.sensors.exact import profile

DOCS = Path(__file__).parents[2] / "docs" / "sensors.md"
CHANNELS = ("gnss", "gyro", "odometer", "heading", "camera")


def all_parts(of: SensorProfile):
    return {"map": of, **of.channels()}


def test_registry_holds_the_profiles_under_their_own_names():
    assert list(PROFILES) == ["dsd", "carla", "dsd_sim", "carla_sim", "nuscenes", "consumer", "urban"]
    assert all(name == entry.name for name, entry in PROFILES.items())


def test_an_unknown_profile_is_answered_with_the_nearest():
    with pytest.raises(GpsecError, match="unknown sensor profile 'nuscene': did you mean 'nuscenes'"):
        PROFILES["nuscene"]


@pytest.mark.parametrize("name", PROFILES)
def test_every_figure_has_a_source(name):
    parts = all_parts(PROFILES[name])
    assert set(parts) == {"map", *CHANNELS}
    for part in parts.values():
        assert part.figures()
        assert set(part.sources) == set(part.figures())
        assert all(len(source) > 20 for source in part.sources.values())


def test_a_figure_without_a_source_is_refused():
    good = PROFILES["dsd"].gyro.model_dump()
    good["sources"].pop("bias_tau_s")
    with pytest.raises(ValidationError, match="no source given for bias_tau_s"):
        Gyro(**good)


def test_an_unknown_figure_and_its_source_are_refused():
    good = PROFILES["dsd"].gyro.model_dump()
    with pytest.raises(ValidationError, match="drift_deg"):
        Gyro(**good, drift_deg=1.0)
    with pytest.raises(ValidationError, match="drift_deg, which is no figure"):
        Gyro(**(good | {"sources": good["sources"] | {"drift_deg": "somewhere"}}))


def test_profiles_are_frozen():
    with pytest.raises(ValidationError, match="frozen"):
        PROFILES["dsd"].gnss.white_m = 1.0


def test_residual_sigma_is_the_root_of_the_sum_of_squares():
    chosen = profile(gnss={"white_m": 2.0, "bias_m": 4.0}, camera={"white_m": 1.0, "bias_m": 2.0, "mount_m": 0.0})
    assert residual_sigma_m(chosen) == 5.0  # √(1 + 4 + 4 + 16)
    chosen = profile(camera={"mount_m": 0.04, "bias_m": 0.03})
    assert residual_sigma_m(chosen) == pytest.approx(0.05, abs=1e-15)


def test_camera_totals_are_those_that_their_sources_name():
    totals = {n: round((p.camera.white_m**2 + p.camera.bias_m**2) ** 0.5, 3) for n, p in PROFILES.items()}
    expected = {"dsd": 0.05, "carla": 0.08, "nuscenes": 0.10, "consumer": 0.066, "urban": 0.066}
    assert totals == expected | {"dsd_sim": 0.05, "carla_sim": 0.08}


@pytest.mark.parametrize("condition", ["good", "night", "rain", "worn"])
def test_cameras_of_real_cars_are_as_rendered_pictures_say(condition):
    """Correlation time, correlation of C0 and C1 and kurtosis of the tapes, within a factor of two; 0.3 to 2.0 s."""
    tape, _ = load_tape(f"rendered-{condition}")
    lag = round(tape.rate_hz)
    pairs, c0, c1 = [], [], []
    for begin, end in zip(tape.piece, [*tape.piece[1:], len(tape.errors)], strict=True):
        errors, there = tape.errors[begin:end], ~tape.missing[begin:end]
        both = there[lag:] & there[:-lag]
        pairs.append((errors[lag:, 0] * errors[:-lag, 0])[both])
        c0.append(errors[there, 0])
        c1.append(errors[there, 1])
    offset, slope = np.concatenate(c0), np.concatenate(c1)
    after_1_s = np.concatenate(pairs).mean() / offset.var()
    kurtosis = np.mean(offset**4) / offset.var() ** 2
    for name in ("dsd", "carla", "nuscenes", "consumer", "urban"):
        camera = PROFILES[name].camera
        assert np.exp(-1.0 / camera.bias_tau_s) == pytest.approx(after_1_s, abs=0.1)
        assert camera.slope_correlation == pytest.approx(np.corrcoef(offset, slope)[0, 1], abs=0.05)
        share, factor = camera.tail_share, camera.tail_factor
        made = 3.0 * (1.0 - share + share * factor**4) / (1.0 - share + share * factor**2) ** 2
        assert 0.5 < made / kurtosis < 2.0
        assert camera.visibility == "place"
    usable = PROFILES["consumer"].camera
    assert 0.5 < np.hypot(usable.white_m, usable.bias_m) / offset.std() < 2.0


@pytest.mark.parametrize("name", ["dsd", "carla"])
def test_a_simulator_has_no_wheel_and_no_mounting(name):
    real, made = PROFILES[name], PROFILES[f"{name}_sim"]
    assert (made.odometer.scale_ratio, made.camera.mount_m) == (0.0, 0.0)
    assert (real.odometer.scale_ratio, real.camera.mount_m) != (0.0, 0.0)
    assert (made.gnss, made.gyro, made.heading) == (real.gnss, real.gyro, real.heading)


@pytest.mark.parametrize("name", ["dsd_sim", "carla_sim"])
def test_a_simulators_camera_is_gaussian_and_loses_paint_by_the_clock(name):
    camera = PROFILES[name].camera
    assert (camera.tail_share, camera.slope_correlation, camera.wrong_line_m) == (None, None, None)
    assert (camera.visibility, camera.bias_tau_s) == ("clock", 10.0)


def test_documentation_holds_every_figure_and_source():
    spec = importlib.util.spec_from_file_location("generate", DOCS.parent / "generate.py")
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    page = DOCS.read_text("utf-8")
    assert generate.sensors_page(page) == page, "python docs/generate.py writes it anew"
    assert "| `multipath_m` |  |  |  |  |  |  | 25 |" in page
    assert "| urban | gnss | `bias_m`, `multipath_m`, `multipath_spread` | public log of an urban canyon" in page
