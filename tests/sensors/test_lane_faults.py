"""Tails, correlated slopes and wrong lines of a camera; without them all is as before, to the last bit."""

import numpy as np
import pytest
from pydantic import ValidationError

from gpsec.core.threads import Threads
from gpsec.testing.drive import Drive
from tests.sensors.exact import profile

WHITE_M = 0.1
TAILS = {"tail_share": 0.1, "tail_factor": 4.0}
WRONG = {"wrong_line_per_h": 360.0, "wrong_line_mean_s": 2.0, "wrong_line_m": 1.5}


def lanes(steps: int = 200, vehicles: int = 300, **camera) -> np.ndarray:
    """Return (S, N, 4) errors of the lanes of standing vehicles in the middle of a straight lane."""
    fleet = Drive((profile(camera={"white_m": WHITE_M, **camera}),), vehicles)
    return np.array([fleet.sense().lane_poly.copy() for _ in range(steps)])


def test_tails_are_a_mixture_of_two_of_the_stated_variance():
    """Of the kurtosis 3·((1 - s) + s·f⁴)/((1 - s) + s·f²)² = 12.7, and narrower in the middle by √2.5."""
    c0 = lanes(**TAILS)[..., 0].ravel()
    assert c0.var() == pytest.approx(WHITE_M**2, rel=0.05)
    assert np.mean(c0**4) / c0.var() ** 2 == pytest.approx(3.0 * (0.9 + 0.1 * 256.0) / 2.5**2, rel=0.1)
    # Those that are no tails are what they were, but smaller.
    before = lanes()[..., 0].ravel()
    assert np.mean(np.isclose(c0 * np.sqrt(2.5), before, rtol=1e-9)) == pytest.approx(0.9, abs=0.01)


def test_slopes_go_with_offsets():
    found = lanes(slope_correlation=-0.8)
    c0, c1 = found[..., 0].ravel(), found[..., 1].ravel()
    assert np.corrcoef(c0, c1)[0, 1] == pytest.approx(-0.8, abs=0.01)
    before = lanes()
    assert c1.std() == pytest.approx(before[..., 1].std(), rel=0.01)
    assert (found[..., [0, 2, 3]] == before[..., [0, 2, 3]]).all()


def test_wrong_lines_are_a_step_to_either_side():
    """0.1 a second and 2 s long: 0.2/(1 + 0.2) of the time, less at first, half of it on each side."""
    found = lanes(steps=600, white_m=0.0, **WRONG)[..., 0]
    assert sorted(set(found.ravel().tolist())) == [-1.5, 0.0, 1.5]
    late = found[200:]
    assert np.mean(late != 0.0) == pytest.approx(0.2 / 1.2, rel=0.08)
    assert np.mean(late > 0.0) == pytest.approx(np.mean(late < 0.0), rel=0.15)
    begins = (found[1:] != 0.0) & (found[:-1] == 0.0)
    # So many of those that may begin do in a step: 0.1 a second.
    assert begins.sum() / (found[:-1] == 0.0).sum() == pytest.approx(1.0 - np.exp(-0.01), rel=0.08)


def test_what_the_camera_states_knows_nothing_of_wrong_lines():
    plain, faulty = (Drive((profile(camera={"white_m": WHITE_M, **more}),), 20) for more in ({}, TAILS | WRONG))
    assert (plain.sense().camera_sigma_m == faulty.sense().camera_sigma_m).all()


def test_beside_a_camera_with_faults_another_one_is_as_before():
    one = profile(camera={"white_m": WHITE_M})
    other = profile("faulty", camera={"white_m": WHITE_M, "slope_correlation": -0.8, **TAILS, **WRONG})
    alone, beside = Drive((one,), 6), Drive((one, other), 6)
    beside.vehicles.profile[:] = 0
    for fleet in (alone, beside):
        fleet.sensors.enter(fleet.state, fleet.vehicles, fleet.rows, 0)
    for _ in range(20):
        assert (alone.sense().lane_poly == beside.sense().lane_poly).all()


def test_the_same_bits_for_two_threads(monkeypatch):
    monkeypatch.setattr(Threads, "MIN_ROWS", 4)
    found = []
    for count in (1, 2):
        fleet, threads = Drive((profile(camera={"white_m": 0.1, **TAILS, **WRONG}),), 40), Threads(count)
        found.append([fleet.sense(threads=threads).lane_poly.tobytes() for _ in range(30)])
        threads.close()
    assert found[0] == found[1]


@pytest.mark.parametrize("figures", [{"tail_share": 0.1}, {"wrong_line_m": 1.5}, {"slope_correlation": -1.0}])
def test_half_a_fault_is_refused(figures):
    with pytest.raises(ValidationError, match=r"together|greater than -1"):
        profile(camera=figures)
