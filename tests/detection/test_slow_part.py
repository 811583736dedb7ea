"""The filter of what is fast and what is slow in a residual, against one of filterpy, and its bounds."""

from math import exp, sqrt

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from gpsec.detection.slow_part import (
    FAST_PART,
    SLOW_PART,
    age_parts,
    correct_parts,
    cut_camera,
    variance_of_parts,
    widen_slow_part,
)
from gpsec.filters.noise import noise_table
from gpsec.pipeline.filter_noise import filter_noise
from gpsec.sensors.registry import PROFILES

STEP_S = 0.1
NOISE = noise_table([filter_noise(PROFILES["carla"], STEP_S)])
CAMERA = PROFILES["carla"].camera
SLOW_VARIANCE = CAMERA.mount_m**2 + PROFILES["carla"].gnss.bias_m ** 2


def begun() -> tuple[np.ndarray, np.ndarray]:
    level, covariance = np.zeros(2), -np.ones(3)
    age_parts(level, covariance, NOISE, 0, STEP_S)
    return level, covariance


def test_it_begins_as_it_is_in_the_long_run():
    level, covariance = begun()
    assert level.tolist() == [0.0, 0.0]
    assert covariance == pytest.approx([CAMERA.bias_m**2, 0.0, SLOW_VARIANCE])
    for _ in range(500):
        age_parts(level, covariance, NOISE, 0, STEP_S)
    assert covariance == pytest.approx([CAMERA.bias_m**2, 0.0, SLOW_VARIANCE])


def test_it_is_the_kalman_filter_of_two_processes():
    level, covariance = begun()
    book = KalmanFilter(2, 1)
    book.P, book.H, book.R = np.diag([CAMERA.bias_m**2, SLOW_VARIANCE]), np.ones((1, 2)), np.array([[0.02]])
    rate = (CAMERA.mount_m**2 / 20.0 + PROFILES["carla"].gnss.bias_m ** 2 / 100.0) / SLOW_VARIANCE
    book.F = np.diag([exp(-STEP_S / CAMERA.bias_tau_s), exp(-STEP_S * rate)])
    book.Q = np.diag([CAMERA.bias_m**2, SLOW_VARIANCE]) @ (np.eye(2) - book.F @ book.F)
    for residual in np.random.default_rng(2).normal(0.05, 0.15, 200):
        total = variance_of_parts(covariance) + 0.02
        correct_parts(level, covariance, NOISE, 0, residual - level[FAST_PART] - level[SLOW_PART], total)
        book.update(residual)
        assert level == pytest.approx(book.x[:, 0], abs=1e-12)
        assert covariance == pytest.approx([book.P[0, 0], book.P[0, 1], book.P[1, 1]], abs=1e-12)
        age_parts(level, covariance, NOISE, 0, STEP_S)
        book.predict()


def test_both_parts_are_bounded():
    level, covariance = begun()
    for _ in range(3000):
        correct_parts(level, covariance, NOISE, 0, 5.0, variance_of_parts(covariance) + 0.01)
        age_parts(level, covariance, NOISE, 0, STEP_S)
    assert level[SLOW_PART] == pytest.approx(3.5 * sqrt(SLOW_VARIANCE), rel=0.01)
    assert abs(level[FAST_PART]) <= 3.5 * CAMERA.bias_m


def test_another_lane_and_a_turn_make_the_slow_part_uncertain():
    _, covariance = begun()
    before = covariance.copy()
    widen_slow_part(covariance, NOISE, 0, True, 0.5)
    assert covariance - before == pytest.approx([0.0, 0.0, 0.07**2 + 0.25 * PROFILES["carla"].gnss.bias_m ** 2])


def test_a_sample_is_cut_at_three_deviations():
    assert [cut_camera(x) for x in (-40.0, -2.9, 0.1, 3.2)] == [-3.0, -2.9, 0.1, 3.0]
