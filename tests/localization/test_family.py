"""A response may bring a filter of its own: the loops are made of its functions."""

import re
from importlib.util import module_from_spec, spec_from_file_location
from typing import ClassVar

import numpy as np
import pytest

from gpsec.core.geo import dead_reckon
from gpsec.core.kernels import inline
from gpsec.localization.family import Filter
from gpsec.localization.responses import Response
from gpsec.testing.rig import Rig


@inline
def start(mean, covariance, noise, profile, x_m, y_m, heading_rad):
    mean[0], mean[1], mean[2] = x_m, y_m, heading_rad
    covariance[0, 0] = covariance[1, 1] = covariance[2, 2] = 0.01


@inline
def predict(mean, covariance, noise, profile, speed_mps, yaw_rate_rps, step_s, isolated):
    mean[0], mean[1] = dead_reckon(mean[0], mean[1], mean[2], speed_mps * step_s, yaw_rate_rps * step_s)
    if isolated:
        mean[3] += 1.0


@inline
def update(mean, covariance, innovation, x_m, y_m, white_m):
    mean[0] += 0.5 * (x_m - mean[0])
    mean[1] += 0.5 * (y_m - mean[1])
    return 1


@inline
def isolate(mean, covariance, noise, profile):
    mean[3] = 100.0


@inline
def take_yaw(mean, covariance, heading_rad, sigma_rad):
    mean[2] = heading_rad


@inline
def drift(noise, profile, way_m):
    return 0.0


@inline
def trust(mean, covariance, noise, profile):
    mean[3] = -1.0


class Halving(Response):
    """Goes half of the way to each fix, and counts the steps without them."""

    name: ClassVar[str] = "halving"
    filter: ClassVar[Filter] = Filter(4, start, predict, update, isolate, take_yaw, drift, trust)


def test_a_filter_from_outside_is_run_beside_the_others(straight):
    rig = Rig(straight, responses=("none", "halving", "ukf"), others={"halving": Halving})
    rig.step()
    rig.step(bias_m=(0.0, 1.0))
    rig.step(bias_m=(0.0, 1.0))
    assert rig.error_m("halving")[0] == pytest.approx([0.0, 0.75])
    assert rig.filter("halving").mean.shape == (4,)
    assert rig.filter("ukf").mean.shape == (5,)
    assert rig.filter("halving").repairs == 2
    for _ in range(3):
        rig.step(bias_m=(0.0, 9.0), alarm=True)
    assert rig.filter("halving").mean[3] == 103.0
    assert rig.error_m("halving")[0] == pytest.approx([0.0, 0.75])
    assert rig.steps_until(False, "halving") == 20
    assert rig.filter("halving").mean[3] == -1.0


def test_the_guides_example_moves_the_estimate_to_where_the_camera_sees_the_vehicle(straight, repository, tmp_path):
    text = (repository / "docs" / "adding-a-response.md").read_text("utf-8")
    (code,) = re.findall(r'^```python\n(""".*?)^```$', text, re.MULTILINE | re.DOTALL)
    (tmp_path / "snap.py").write_text(code, "utf-8")
    spec = spec_from_file_location("snap", tmp_path / "snap.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    rig = Rig(straight, responses=("snap", "dead_reckoning"), others={"snap": module.Snap})
    for _ in range(10):
        rig.step(bias_m=(0.0, 0.3))
    rig.seen.lane_poly[:, 0] = 0.7  # the vehicle sees itself 0.7 m right of the centre
    rig.step(alarm=True)
    assert rig.error_m("snap")[0, 1] == pytest.approx(-0.7, abs=1e-9)
    assert rig.error_m("dead_reckoning")[0, 1] > 0.1
    assert np.isfinite(rig.filter("snap").covariance).all()
