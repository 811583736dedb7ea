from math import cos, exp, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpsec.filters import ekf
from gpsec.filters.noise import FilterNoise, noise_table
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import RIG_FIGURES, Rig, rig_figures

variances = st.floats(1e-4, 5.0)


def random_state(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    root = rng.normal(0.0, 0.3, (5, 5))
    return rng.normal(0.0, [50.0, 50.0, 2.0, 0.3, 0.3]), root @ root.T + 1e-3 * np.eye(5)


def random_figures(seed: int) -> FilterNoise:
    rng = np.random.default_rng(seed)
    return FilterNoise(*rng.uniform(0.01, 1.0, len(FilterNoise._fields)))


def wrapped(angle: float) -> float:
    return (angle + pi) % (2.0 * pi) - pi


def plain_predict(mean, covariance, f: FilterNoise, speed, yaw_rate, dt):
    """The textbook's x' = f(x, u), P' = F P Fᵀ + Q with every matrix written out."""
    x, y, yaw, bias_east, bias_north = mean
    turn = yaw_rate * dt
    if abs(turn) > 1e-6:
        radius = speed / yaw_rate
        dx, dy = radius * (sin(yaw + turn) - sin(yaw)), radius * (cos(yaw) - cos(yaw + turn))
    else:
        dx, dy = speed * dt * cos(yaw + turn / 2), speed * dt * sin(yaw + turn / 2)
    decay = exp(-dt / f.gnss_bias_tau_s)
    F = np.diag([1.0, 1.0, 1.0, decay, decay])
    F[0, 2], F[1, 2] = -dy, dx
    middle = yaw + turn / 2
    along = np.array([cos(middle), sin(middle), 0.0, 0.0, 0.0])
    lasting = dt * 1.0  # an error that lasts counts as noise of one second's correlation
    Q = np.outer(along, along) * ((f.odometer_white_mps * dt) ** 2 + (f.odometer_scale * speed) ** 2 * lasting)
    Q += np.diag([0.0, 0.0, (f.gyro_white_rps * dt) ** 2 + f.gyro_bias_rps**2 * lasting, 0.0, 0.0])
    Q += np.diag([0.0, 0.0, 0.0, 1.0, 1.0]) * f.gnss_bias_m**2 * (1.0 - decay**2)
    after = np.array([x + dx, y + dy, wrapped(yaw + turn), bias_east * decay, bias_north * decay])
    return after, F @ covariance @ F.T + Q


def plain_update(mean, covariance, f: FilterNoise, fix):
    """Both axes at once: H = [I 0 I]."""
    H = np.array([[1.0, 0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0, 1.0]])
    S = H @ covariance @ H.T + f.gnss_white_m**2 * np.eye(2)
    nu = np.asarray(fix) - H @ mean
    K = covariance @ H.T @ np.linalg.inv(S)
    after = mean + K @ nu
    after[2] = wrapped(after[2])
    return after, (np.eye(5) - K @ H) @ covariance, float(nu @ np.linalg.inv(S) @ nu)


@given(st.integers(0, 10**6), st.floats(-5.0, 40.0), st.floats(-1.0, 1.0))
def test_predict_is_the_textbooks(seed, speed, yaw_rate):
    f = random_figures(seed)
    mean, P = random_state(seed)
    expected, expected_P = plain_predict(mean, P, f, speed, yaw_rate, STEP_S)
    ekf.predict_pose(mean, P, noise_table([RIG_FIGURES, f]), 1, speed, yaw_rate, STEP_S)
    assert mean == pytest.approx(expected, abs=1e-9)
    assert pytest.approx(expected_P, abs=1e-9) == P


@given(st.integers(0, 10**6), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_update_is_the_textbooks_and_its_innovations_sum_to_the_nis(seed, east, north):
    f = random_figures(seed)
    mean, P = random_state(seed)
    fix = mean[:2] + np.array([east, north])
    expected, expected_P, nis = plain_update(mean, P, f, fix)
    innovation = np.zeros(2)
    repairs = ekf.update(mean, P, innovation, fix[0], fix[1], f.gnss_white_m)
    assert repairs == 0
    assert wrapped(mean[2] - expected[2]) == pytest.approx(0.0, abs=1e-9)
    assert np.delete(mean, 2) == pytest.approx(np.delete(expected, 2), abs=1e-9)
    assert pytest.approx(expected_P, abs=1e-9) == P
    assert (innovation**2).sum() == pytest.approx(nis, rel=1e-6)


def test_start_is_a_fix_minus_an_unknown_slow_error():
    """Position = fix - slow error: Var = white² + bias², Cov(position, slow error) = -bias²."""
    mean, P = np.full(5, 9.0), np.full((5, 5), 9.0)
    ekf.start_at_fix(mean, P, noise_table([RIG_FIGURES]), 0, 3.0, 4.0, 7.0)
    white, bias = RIG_FIGURES.gnss_white_m**2, RIG_FIGURES.gnss_bias_m**2
    assert mean == pytest.approx([3.0, 4.0, 7.0 - 2.0 * pi, 0.0, 0.0])
    expected = np.diag([white + bias, white + bias, RIG_FIGURES.heading_rad**2, bias, bias])
    expected[0, 3] = expected[3, 0] = expected[1, 4] = expected[4, 1] = -bias
    assert pytest.approx(expected) == P
    # Before the update, the fix that it started with would surprise by its white noise alone.
    H = np.array([1.0, 0.0, 0.0, 1.0, 0.0])
    assert pytest.approx(white) == H @ P @ H


@pytest.mark.parametrize("period", [1, 2, 10])
def test_covariance_stays_symmetric_and_positive(period):
    rng = np.random.default_rng(1)
    table, innovation = noise_table([RIG_FIGURES]), np.zeros(2)
    mean, P = np.zeros(5), np.zeros((5, 5))
    ekf.start_at_fix(mean, P, table, 0, 0.0, 0.0, 0.0)
    repairs = 0
    for step in range(3000):
        ekf.predict_pose(mean, P, table, 0, rng.uniform(0.0, 30.0), rng.normal(0.0, 0.3), STEP_S)
        if step % period == 0:
            fix = mean[:2] + rng.normal(0.0, 0.2, 2)
            repairs += ekf.update(mean, P, innovation, fix[0], fix[1], RIG_FIGURES.gnss_white_m)
        if step % 100 == 0:
            assert abs(P - P.T).max() < 1e-12
            assert np.linalg.eigvalsh(P).min() > -1e-12
    assert repairs == 0


def test_a_negative_variance_is_repaired_and_counted():
    # From a covariance that is none: correlation above 1.
    P = np.eye(5)
    P[0, 2] = P[2, 0] = 5.0
    repairs = ekf.update(np.zeros(5), P, np.zeros(2), 0.0, 0.0, 0.1)
    assert repairs == 1
    assert P[2, 2] == 0.0


def test_errors_are_as_large_as_the_filter_says():
    """Normalised error squared of fixes and odometry drawn from the filter's own model: 5 on average."""
    rng = np.random.default_rng(3)
    f = rig_figures(odometer_scale=0.0, gyro_bias_rps=0.0)
    table, innovation, squares = noise_table([f]), np.zeros(2), []
    for _ in range(60):
        truth, bias = np.zeros(3), rng.normal(0.0, f.gnss_bias_m, 2)
        fix = truth[:2] + bias + rng.normal(0.0, f.gnss_white_m, 2)
        mean, P = np.zeros(5), np.zeros((5, 5))
        ekf.start_at_fix(mean, P, table, 0, fix[0], fix[1], rng.normal(0.0, f.heading_rad))
        decay = exp(-STEP_S / f.gnss_bias_tau_s)
        for step in range(100):
            speed, rate = 10.0, 0.2 * cos(step / 20.0)
            middle = truth[2] + rate * STEP_S / 2
            truth += STEP_S * np.array([speed * cos(middle), speed * sin(middle), rate])
            bias = decay * bias + rng.normal(0.0, f.gnss_bias_m * np.sqrt(1.0 - decay**2), 2)
            seen = speed + rng.normal(0.0, f.odometer_white_mps), rate + rng.normal(0.0, f.gyro_white_rps)
            ekf.predict_pose(mean, P, table, 0, seen[0], seen[1], STEP_S)
            fix = truth[:2] + bias + rng.normal(0.0, f.gnss_white_m, 2)
            ekf.update(mean, P, innovation, fix[0], fix[1], f.gnss_white_m)
        error = np.concatenate([truth, bias]) - mean
        error[2] = wrapped(error[2])
        squares.append(error @ np.linalg.solve(P, error))
    # The mean of 60 chi-squares of 5 degrees of freedom has a standard error of sqrt(10/60).
    assert np.mean(squares) == pytest.approx(5.0, abs=4.0 * np.sqrt(10.0 / 60.0))


@pytest.mark.parametrize("bias", [(0.0, 2.0), (0.0, -0.7), (1.5, 0.0)])
def test_the_undefended_estimate_ends_up_at_the_bias(straight, bias):
    rig = Rig(straight, responses=("none",), speed_mps=5.0)
    for _ in range(50):
        rig.step()
    assert rig.error_m("none")[0] == pytest.approx([0.0, 0.0], abs=1e-9)
    for _ in range(1500):
        rig.step(bias_m=bias)
    assert rig.error_m("none")[0] == pytest.approx(bias, abs=0.02)
    assert rig.filter("none").mean[3:] == pytest.approx([0.0, 0.0], abs=0.02)


def test_perfect_sensors_make_no_error(straight):
    rig = Rig(straight)
    for step in range(300):
        rig.step(fix=step % 3 == 0)
        for response in rig.responses:
            if step > 0:
                assert abs(rig.error_m(response)).max() < 1e-9
