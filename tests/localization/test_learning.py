from math import cos, exp, pi

import numpy as np
import pytest

from gpsec.filters import learning
from gpsec.filters.noise import noise_table
from gpsec.localization.learning import LEARNING_EKF
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import Rig, rig_figures

RIG_FIGURES = rig_figures(gyro_bias_rps=2e-3, odometer_scale=0.02)
LATE_FIGURES = RIG_FIGURES._replace(gyro_latency_s=0.05)
STATES = learning.LEARNING_STATES


def moved(mean: np.ndarray, speed: float, rate: float, isolated: bool) -> np.ndarray:
    after = mean.copy()
    LEARNING_EKF.predict(
        after, np.zeros((STATES, STATES)), noise_table([LATE_FIGURES]), 0, speed, rate, STEP_S, isolated
    )
    return after


@pytest.mark.parametrize("isolated", [False, True])
def test_the_covariance_follows_the_derivatives_of_the_motion(isolated):
    """F by central differences of the mean; Q is what a covariance of zero becomes."""
    mean = np.array([3.0, -2.0, 0.7, 0.05, -0.03, 0.01, 1e-3])
    rng = np.random.default_rng(0)
    root = rng.normal(size=(STATES, STATES))
    P = root @ root.T
    F = np.empty((STATES, STATES))
    for i in range(STATES):
        step = np.zeros(STATES)
        step[i] = 1e-5
        F[:, i] = (moved(mean + step, 12.0, 0.3, isolated) - moved(mean - step, 12.0, 0.3, isolated)) / 2e-5
    Q, found = np.zeros((STATES, STATES)), P.copy()
    table = noise_table([LATE_FIGURES])
    LEARNING_EKF.predict(mean.copy(), Q, table, 0, 12.0, 0.3, STEP_S, isolated)
    LEARNING_EKF.predict(mean.copy(), found, table, 0, 12.0, 0.3, STEP_S, isolated)
    # The chord also shortens as its turn grows, by a thousandth of the way in a second; F leaves that out.
    np.testing.assert_allclose(found, F @ P @ F.T + Q, atol=5e-3)


@pytest.mark.parametrize(("told_s", "worst_m"), [(0.0, 0.4), (0.1, 0.03)])
def test_a_filter_that_knows_its_gyro_to_be_late_goes_round_a_bend(told_s, worst_m):
    """Of a yaw rate that is 0.1 s late, 0.05 rad are missing in a turn of 0.5 rad/s: 0.5 m in 10 m."""
    table = noise_table([rig_figures(gyro_latency_s=told_s)])

    def rate(at_s: float) -> float:
        return 0.5 * min(max(at_s - 0.5, 0.0), 1.0)

    mean, P, truth, worst = np.zeros(STATES), np.zeros((STATES, STATES)), np.zeros(3), 0.0
    for step in range(30):
        for part in range(100):
            now = (step + (part + 0.5) / 100.0) * STEP_S
            truth[2] += rate(now) * STEP_S / 100.0
            truth[:2] += 5.0 * STEP_S / 100.0 * np.array([cos(truth[2]), sin_of(truth[2])])
        LEARNING_EKF.predict(mean, P, table, 0, 5.0, rate((step + 0.5) * STEP_S - 0.1), STEP_S, True)
        worst = max(worst, float(np.hypot(*(mean[:2] - truth[:2]))))
    assert (worst > worst_m) == (told_s == 0.0)


def test_errors_are_as_large_as_the_filter_says():
    """Normalised error squared of odometry and fixes drawn from the filter's own model: 7 on average."""
    rng, f = np.random.default_rng(3), RIG_FIGURES
    table, innovation, squares, scales = noise_table([f]), np.zeros(2), [], []
    decay, keeps = exp(-STEP_S / f.gnss_bias_tau_s), exp(-STEP_S / f.gyro_bias_tau_s)
    for _ in range(60):
        truth, slow = np.zeros(3), rng.normal(0.0, f.gnss_bias_m, 2)
        scale, gyro = rng.normal(0.0, f.odometer_scale), rng.normal(0.0, f.gyro_bias_rps)
        fix = truth[:2] + slow + rng.normal(0.0, f.gnss_white_m, 2)
        mean, P = np.zeros(STATES), np.zeros((STATES, STATES))
        LEARNING_EKF.start(mean, P, table, 0, fix[0], fix[1], rng.normal(0.0, f.heading_rad))
        for step in range(150):
            speed, rate = 10.0, 0.2 * cos(step / 20.0)
            middle = truth[2] + rate * STEP_S / 2
            truth += STEP_S * np.array([speed * cos(middle), speed * sin_of(middle), rate])
            slow = decay * slow + rng.normal(0.0, f.gnss_bias_m * np.sqrt(1.0 - decay**2), 2)
            gyro = keeps * gyro + rng.normal(0.0, f.gyro_bias_rps * np.sqrt(1.0 - keeps**2))
            seen_speed = speed * (1.0 + scale) + rng.normal(0.0, f.odometer_white_mps)
            seen_rate = rate + gyro + rng.normal(0.0, f.gyro_white_rps)
            LEARNING_EKF.predict(mean, P, table, 0, seen_speed, seen_rate, STEP_S, False)
            fix = truth[:2] + slow + rng.normal(0.0, f.gnss_white_m, 2)
            assert LEARNING_EKF.update(mean, P, innovation, fix[0], fix[1], f.gnss_white_m) == 0
        error = np.concatenate([truth, slow, [scale, gyro]]) - mean
        error[2] = (error[2] + pi) % (2.0 * pi) - pi
        squares.append(error @ np.linalg.solve(P, error))
        scales.append(abs(error[5]))
    # The mean of 60 chi-squares of 7 degrees of freedom has a standard error of sqrt(14/60).
    assert np.mean(squares) == pytest.approx(7.0, abs=4.0 * np.sqrt(14.0 / 60.0))
    # 150 m of way and a receiver of some 5 cm: the scale is known far better than from the data sheet.
    assert np.mean(scales) < 0.1 * f.odometer_scale


def sin_of(angle: float) -> float:
    return cos(angle - pi / 2.0)


def test_what_was_learnt_carries_through_isolation(straight):
    """An odometer that counts 2 % too much: 300 m become 306 m, unless that has been learnt."""
    rig = Rig(straight, responses=("ukf", "ukf5"), figures=rig_figures(odometer_scale=0.02), speed_mps=10.0)
    rig.seen.speed_mps[:] = 10.2
    for _ in range(300):
        rig.step()
    learnt = rig.filter("ukf5").mean[learning.SCALE]
    assert learnt == pytest.approx(0.02, abs=5e-4)
    for _ in range(300):
        rig.step(alarm=True)
    assert rig.error_m("ukf")[0, 0] == pytest.approx(6.0, abs=0.3)
    assert abs(rig.error_m("ukf5")[0, 0]) < 0.15


def test_the_slow_error_changes_hands(straight):
    """Isolated it is the camera's and its mounting, of the data sheet's sizes; with GNSS again that of the receiver."""
    rig = Rig(straight, responses=("ukf5",))
    for _ in range(20):
        rig.step()
    rig.step(alarm=True, camera=False)
    f, slow = rig.figures, slice(3, 5)
    camera = [f.camera_bias_m**2, f.camera_mount_m**2]
    assert np.diag(rig.filter("ukf5").covariance)[slow] == pytest.approx(camera, abs=1e-12)
    scale = rig.filter("ukf5").mean[learning.SCALE]
    assert rig.steps_until(False, "ukf5") == 20
    P = rig.filter("ukf5").covariance
    assert np.diag(P)[slow] == pytest.approx([f.gnss_bias_m**2] * 2)
    assert rig.filter("ukf5").mean[learning.SCALE] == pytest.approx(scale, abs=1e-9)
    assert np.linalg.eigvalsh(P).min() > -1e-12
