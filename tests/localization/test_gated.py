"""The gate: fixes that contradict odometer and gyro are refused, without an alarm."""

import numpy as np
import pytest

from gpsec.localization.gated import LEARNT_NOISE
from gpsec.reference.learning import GatedEkf
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import RIG_FIGURES, Rig, rig_figures


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
    """As soon as P allows for it, although all fixes that were refused are off to the same side."""
    rig = Rig(straight, responses=("gate",), figures=rig_figures(odometer_white_mps=1.0))
    for _ in range(150):
        rig.step()
    rig.vehicles.rear_m[:, 0] += 1.5
    rig.step()
    assert rig.error_m("gate")[0, 0] < -1.4
    # The odometer adds 0.01 m² in a step: after 100 of them, the slip is 1.5 standard deviations.
    for _ in range(100):
        rig.step()
    assert abs(rig.error_m("gate")[0, 0]) < 0.2


@pytest.mark.parametrize(("factor", "low", "high"), [(1.0, 0.7, 1.3), (1.5, 1.6, 2.5), (3.0, 2.3, 2.5)])
def test_it_learns_how_noisy_fixes_are_up_to_a_bound(straight, factor, low, high):
    rng = np.random.default_rng(5)
    rig = Rig(straight, responses=("gate",))
    learnt = []
    for step in range(2500):
        rig.step(bias_m=rng.normal(0.0, factor * RIG_FIGURES.gnss_white_m, 2))
        learnt += [np.exp(rig.filter("gate").mean[LEARNT_NOISE])] * (step > 1000)
    assert low < np.median(learnt) <= high * 1.001


def test_it_learns_nothing_from_fixes_that_are_strange(straight):
    rig = driven(straight)
    rig.step(bias_m=(0.0, 2.4))
    before = rig.filter("gate").mean[LEARNT_NOISE]
    for _ in range(100):
        rig.step(bias_m=(0.0, 2.4))
    assert rig.filter("gate").mean[LEARNT_NOISE] == before


def test_it_is_the_filter_of_the_reference_in_and_out_of_the_gate(straight):
    rng = np.random.default_rng(7)
    rig = Rig(straight, responses=("gate",))
    reference, refused, most = None, 0, 0.0
    for step in range(900):
        # Jumps, drifts and noisy times, with honest ones between.
        drift_m = 0.02 * (step % 300) if step % 300 > 200 else 0.0
        jump_m = 2.4 if 100 < step % 300 < 130 else 0.0
        sigma_m = RIG_FIGURES.gnss_white_m * (1.0 + step // 300)
        rig.seen.yaw_rate_rps[:] = rng.normal(0.0, RIG_FIGURES.gyro_white_rps)
        rig.step(bias_m=rng.normal((jump_m, drift_m), sigma_m))
        fix_m = rig.tracks.fix_m[0].copy()
        if reference is None:
            reference = GatedEkf.at_first_fix(RIG_FIGURES, fix_m, 0.0)
            continue
        reference.predict(rig.speed_mps, float(rig.seen.yaw_rate_rps[0]), STEP_S)
        before = reference.covariance[0, 0]
        reference.update(fix_m)
        refused += bool(reference.covariance[0, 0] == before)
        filter_ = rig.filter("gate")
        size = len(reference.mean)
        assert filter_.mean[:size] == pytest.approx(reference.mean, abs=1e-9)
        assert filter_.covariance[:size, :size] == pytest.approx(reference.covariance, abs=1e-9)
        assert filter_.mean[LEARNT_NOISE] == pytest.approx(reference.learnt, abs=1e-9)
        most = max(most, reference.learnt)
    assert 100 < refused < 800
    assert most > 0.1
