"""Multipath by place: its variance, its reach, and that neighbours share it; `urban` beside the log of a canyon."""

import numpy as np
import pytest
from pydantic import ValidationError

from gpsec.sensors.mismatch import AS_STATED, Mismatch
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.shared_errors import SharedErrors
from gpsec.testing.drive import Drive
from tests.sensors.exact import profile

FIGURES = {"bias_m": 40.0, "multipath_m": 20.0, "multipath_spread": 0.5, "multipath_length_m": 70.0}


def errors(place_m, seed=1, chosen=None, mismatch=AS_STATED) -> np.ndarray:
    """Return (n, 2) what multipath does to fixes at (n, 2) places: what stays the same for a vehicle is taken out."""
    fleet = Drive((chosen or profile(gnss=FIGURES),), len(place_m), mismatch=mismatch)
    fleet.vehicles.rear_m[:] = place_m
    around = SharedErrors(fleet.sensors, seed)
    before = fleet.sense().fix_m.copy()
    around.disturb(around.new_state().now, fleet.rows, 0, fleet.vehicles, fleet.measurements)
    return fleet.measurements.fix_m - before


def line(count: int, apart_m: float) -> np.ndarray:
    return np.stack([np.arange(count) * apart_m, np.full(count, -1234.5)], axis=1)


def test_its_mean_square_over_places_is_that_of_a_lognormal_mixture():
    """σ²·exp(2·s²), over 60 km of both axes."""
    found = errors(np.random.default_rng(3).uniform(-30e3, 30e3, (40_000, 2)))
    assert np.mean(found**2) == pytest.approx(20.0**2 * np.exp(0.5), rel=0.05)


def test_it_is_continuous_and_fades_with_distance():
    found = errors(line(60_000, 7.0))
    variance = np.mean(found**2)
    step = errors(line(2000, 0.01))
    assert np.abs(np.diff(step, axis=0)).max() < 0.05
    correlation = [np.mean(found[lag:] * found[:-lag]) / variance for lag in (1, 9, 40)]
    assert correlation[0] > 0.97
    assert correlation[1] == pytest.approx(np.exp(-1.0), abs=0.06)  # 63 m are 0.9 sides of the squares
    assert abs(correlation[2]) < 0.06


def test_who_is_at_the_same_place_is_off_by_the_same_in_every_batch():
    place = np.array([[12.0, 34.0], [500.0, 6.0], [12.0, 34.0]])
    found = errors(place)
    assert found[0] == pytest.approx(found[2], abs=1e-9)
    assert (found[0] != found[1]).any()
    assert errors(place[1:]) == pytest.approx(found[1:], abs=1e-9)
    assert (errors(place, seed=2) != found).any()


def test_a_factor_on_the_slow_error_is_one_on_it():
    place = line(50, 40.0)
    assert errors(place, mismatch=Mismatch(gnss_slow=2.0)) == pytest.approx(2.0 * errors(place), rel=1e-9)


def test_another_profile_has_none_of_it():
    fleet = Drive((profile(gnss=FIGURES), profile("other")), 4)
    around = SharedErrors(fleet.sensors, 1)
    fleet.sense()
    before = fleet.measurements.fix_m.copy()
    around.disturb(around.new_state().now, fleet.rows, 0, fleet.vehicles, fleet.measurements)
    changed = (fleet.measurements.fix_m != before).any(axis=1)
    assert changed.tolist() == [True, False, True, False]


def test_urban_is_as_the_log_of_a_canyon():
    """Across MAD 16 m, p95 65 m, 1/e after about 8 s at 8 m/s (docs/sensors.md)."""
    urban = PROFILES["urban"]
    # `errors` subtracts fixes, so white noise and wander are out of it.
    found = errors(np.random.default_rng(5).uniform(-40e3, 40e3, (40_000, 2)), chosen=urban)[:, 0]
    moved = np.abs(found[found != 0.0])  # a receiver of 5 Hz has a fix in every second step
    assert np.median(moved) == pytest.approx(16.0, rel=0.05)
    assert np.quantile(moved, 0.95) == pytest.approx(65.0, rel=0.08)


@pytest.mark.parametrize(
    ("figures", "said"),
    [
        ({"multipath_m": 20.0}, "expected multipath_m, multipath_spread, multipath_length_m together"),
        (FIGURES | {"bias_m": 5.0}, r"expected wander and multipath within bias_m = 5 m, found 25\.7 m"),
    ],
)
def test_half_of_it_is_refused(figures, said):
    with pytest.raises(ValidationError, match=said):
        profile(gnss={"bias_m": 40.0} | figures)
