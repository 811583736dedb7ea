"""The gate: fixes that contradict odometer and gyro are refused, without an alarm."""

import numpy as np
import pytest

from gpsec.testing.rig import Rig, rig_figures


def driven(straight, steps=150) -> Rig:
    rig = Rig(straight, responses=("gate", "none"))
    for _ in range(steps):
        rig.step()
    return rig


@pytest.mark.parametrize("bias_m", [(0.0, 2.4), (5.0, 0.0)])
def test_a_jump_is_refused_for_as_long_as_it_lasts(straight, bias_m):
    rig = driven(straight)
    for _ in range(100):
        rig.step(bias_m=bias_m)
    assert np.abs(rig.error_m("gate")[0]).max() < 0.01
    assert np.abs(rig.error_m("none")[0]).max() > 0.5 * max(bias_m)
    assert not rig.isolated("gate")


def test_a_drift_that_no_single_fix_betrays_is_refused_too(straight):
    rig = driven(straight)
    singly = []
    for step in range(100):
        rig.step(bias_m=(0.0, 0.03 * step))
        singly.append((rig.filter("none").innovation ** 2).sum())
    # The last fix is 3 m off; the filter that takes all of them finds none that is strange.
    assert max(singly) < 13.8
    assert abs(rig.error_m("gate")[0, 1]) < 0.5
    assert rig.error_m("none")[0, 1] > 2.0


def test_honest_fixes_are_used_at_once_after_an_attack(straight):
    rig = driven(straight)
    for _ in range(50):
        rig.step(bias_m=(0.0, 2.4))
    before = rig.filter("gate").covariance[0, 0]
    for _ in range(5):
        rig.step()
    assert rig.filter("gate").covariance[0, 0] < before


def test_the_gate_opens_where_a_vehicle_has_slipped(straight):
    rig = Rig(straight, responses=("gate",), figures=rig_figures(odometer_white_mps=1.0))
    for _ in range(150):
        rig.step()
    rig.vehicles.rear_m[:, 0] += 1.5
    for _ in range(900):
        rig.step()
    assert abs(rig.error_m("gate")[0, 0]) < 0.2
