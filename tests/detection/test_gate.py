"""The gate of the monitor: which threshold it is, and what is found with it."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.detection.calibration import Calibrated, replay
from gpsec.detection.gate import gate_of, with_gate
from gpsec.detection.joint import Joint
from gpsec.detection.logs import Grid
from gpsec.detection.models import ProfileModel, gates_for
from gpsec.detection.monitored import monitored
from gpsec.detection.rare import GatedHarvest, Harvest
from gpsec.detection.registry import DETECTORS
from gpsec.testing.residuals import make_log
from gpsec.testing.watched import watched_log


def model_with(**by_rate):
    rates = {"h01": "0.1/h", "h1": "1/h", "sample": "1e-3/sample"}
    return ProfileModel({}, {rates[at]: {"joint": one and Calibrated(one, 0.1)} for at, one in by_rate.items()})


@pytest.fixture(scope="module")
def grid() -> Grid:
    """22 vehicle-hours that end with a second of fixes which are off, on one vehicle of twenty."""
    log = watched_log(make_log(400, 2000, seed=5, tau_s=3.0, gaps=False))
    off = (log.step > 1000) & (log.step < 1010) & (log.vehicle % 20 == 0)
    inputs = log.inputs._replace(fix_north_m=log.inputs.fix_north_m - 0.04 * (log.vehicle % 100 + 1) * off)
    return Grid.of([replace(log, residual_m=-inputs.fix_north_m, inputs=inputs)])


def test_the_gate_is_the_threshold_of_joint_at_the_strictest_rate_that_there_is():
    assert gate_of(model_with(h01=42.0, h1=33.0, sample=22.0).thresholds) == 42.0
    assert gate_of(model_with(h01=None, h1=33.0, sample=22.0).thresholds) == 33.0
    assert gate_of(model_with(h01=None, sample=22.0).thresholds) == 22.0
    assert gate_of({"0.1/h": {"cusum": Calibrated(9.0, 0.1)}}) is None


def test_each_profile_has_its_own_and_one_without_joint_is_refused():
    models = {("one", "tracked"): model_with(h01=42.0), ("other", "tracked"): model_with(h01=55.0)}
    assert gates_for(["one", "other"], "oracle", models).tolist() == [42.0, 55.0]
    with pytest.raises(GpsecError, match=r"profile 'none', association 'tracked': no threshold of joint.*gpsec train"):
        gates_for(["none"], "tracked", {("none", "tracked"): ProfileModel({}, {})})


def test_gate_and_threshold_are_one_number_and_change_only_vehicles_that_reach_it(grid):
    gated, found = with_gate(grid, 10.0)
    # 21 vehicle-hours are too few for 0.1/h.
    ((rate, gate),) = found.items()
    assert rate == "1/h"
    opened = monitored(grid, inf)
    over = (opened.channels.joint > gate.threshold).any(axis=0)
    assert 0 < over.sum() < 100
    assert np.array_equal((gated.channels.joint > gate.threshold).any(axis=0), over)
    for one, other in zip(gated.channels, opened.channels, strict=True):
        assert np.array_equal(one[:, ~over], other[:, ~over])
    assert not np.array_equal(gated.channels.joint[:, over], opened.channels.joint[:, over])
    whole = replay(Joint(), gated, gate.threshold, 10.0)
    assert gate.achieved == whole.onsets / whole.hours == pytest.approx(1.0, rel=0.15)


def test_vehicles_that_came_near_are_enough_to_find_gate_and_thresholds(grid):
    built = [DETECTORS[name].build([]) for name in ("innovation", "joint", "separation")]
    halves = [grid.select(np.arange(len(grid.length)) % 2 == half) for half in (0, 1)]
    gated = GatedHarvest([Harvest(detector, 10.0) for detector in built])
    for half in halves:
        gated.take(half)
    assert sum(len(near.length) for near in gated.near.groups()) < 200
    hours = gated.harvests[0].hours
    assert hours == pytest.approx(len(grid.length) * 190.0 / 3600.0)
    kept = gated.calibrated(130.0)
    # 20 vehicle-hours do not tell 0.1/h: the gate stays what it was, and nothing is said of joint at that rate.
    assert kept["joint"]["0.1/h"] is None
    whole = monitored(Grid.joined(halves), 130.0)
    for harvest in gated.harvests:
        # The same of all vehicles at once, behind the gate from the beginning.
        alone = Harvest(harvest.detector, 10.0)
        peaks = alone.look(whole)
        assert alone.hours == harvest.hours
        alone.peaks = harvest.peaks
        assert alone.calibrated_on([whole], peaks) == kept[harvest.detector.name]


def test_grids_that_are_joined_have_their_vehicles_side_by_side(grid):
    short = Grid.of([make_log(3, 50, seed=1)])
    whole = Grid.joined([short, replace(grid, inputs=None)])
    assert whole.length.tolist() == [*grid.length.tolist(), 50, 50, 50]
    assert np.array_equal(whole.residual_m[:, :-3], grid.residual_m)
    assert np.array_equal(whole.residual_m[:50, -3:], short.residual_m)
    assert not whole.valid[50:, -3:].any()


def test_a_log_without_what_the_monitor_is_handed_is_refused():
    with pytest.raises(GpsecError, match="expected what the monitor is handed"):
        monitored(Grid.of([make_log(2, 5)]), 41.0)
