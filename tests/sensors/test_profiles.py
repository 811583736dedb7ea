import re
from pathlib import Path

import pytest
from pydantic import ValidationError

from gpsec.core.errors import GpsecError
from gpsec.sensors.profiles import Gyro, SensorProfile, residual_sigma_m
from gpsec.sensors.registry import PROFILES
from tests.sensors.exact import profile

DOCS = Path(__file__).parents[2] / "docs" / "sensors.md"
CHANNELS = ("gnss", "gyro", "odometer", "heading", "camera")


def all_parts(of: SensorProfile):
    return {"map": of, **of.channels()}


def test_registry_holds_the_profiles_under_their_own_names():
    assert list(PROFILES) == ["dsd", "carla", "dsd_sim", "carla_sim", "nuscenes", "consumer"]
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


def test_consumer_gnss_is_the_circular_error_of_its_data_sheet():
    gnss = PROFILES["consumer"].gnss
    axis = (gnss.white_m**2 + gnss.bias_m**2) ** 0.5
    # Half of the errors of a circular normal distribution lie within √(2 ln 2) σ.
    assert axis * 1.17741 == pytest.approx(2.5, abs=0.01)


def test_camera_totals_are_those_that_their_sources_name():
    totals = {n: (p.camera.white_m**2 + p.camera.bias_m**2) ** 0.5 for n, p in PROFILES.items()}
    expected = {"dsd": 0.05, "carla": 0.08, "nuscenes": 0.10, "consumer": 0.15}
    assert totals == pytest.approx(expected | {"dsd_sim": 0.05, "carla_sim": 0.08})


@pytest.mark.parametrize("name", ["dsd", "carla"])
def test_a_simulator_has_no_wheel_and_no_mounting(name):
    real, made = PROFILES[name], PROFILES[f"{name}_sim"]
    assert (made.odometer.scale_ratio, made.camera.mount_m) == (0.0, 0.0)
    assert (real.odometer.scale_ratio, real.camera.mount_m) != (0.0, 0.0)
    assert (made.gnss, made.gyro, made.heading) == (real.gnss, real.gyro, real.heading)


def documented_figures():
    """Return {(channel, figure): [value per profile]} of the tables in the documentation."""
    found, channel = {}, None
    for line in DOCS.read_text().splitlines():
        if heading := re.match(r"### `(\w+)`", line):
            channel = heading.group(1)
        row = re.match(r"\| `(\w+)` \| (.*) \|$", line)
        if channel and row:
            found[channel, row.group(1)] = [float(cell) for cell in row.group(2).split("|")]
    return found


def test_documentation_holds_every_figure():
    in_code = {}
    for entry in PROFILES.values():
        for channel, part in all_parts(entry).items():
            for figure, value in part.figures().items():
                in_code.setdefault((channel, figure), []).append(value)
    assert documented_figures() == in_code


def test_documentation_holds_every_source_with_the_figures_it_is_for():
    text = DOCS.read_text()
    for entry in PROFILES.values():
        for channel, part in all_parts(entry).items():
            for source in set(part.sources.values()):
                figures = ", ".join(f"`{figure}`" for figure in part.figures() if part.sources[figure] == source)
                assert f"| {entry.name} | {channel} | {figures} | {source} |" in text
