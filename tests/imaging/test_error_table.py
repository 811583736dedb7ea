"""The error table and tapes, of errors whose statistics are known."""

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.imaging.filming.error_table import decay_s, figures_of, tape_of
from gpsec.imaging.filming.measure import Errors
from gpsec.types.tapes import write_tape


def errors(count=4000, tau=10.0, shift=0.0, seed=1, lost=()):
    """C0 is first-order Gauss-Markov of deviation 0.1 m; the 40 % nearest to junctions come first."""
    draw = np.random.default_rng(seed)
    keep = np.exp(-1.0 / tau)
    values = np.zeros(count)
    values[0] = draw.normal(0.0, 0.1)
    for k in range(1, count):
        values[k] = keep * values[k - 1] + np.sqrt(1.0 - keep**2) * draw.normal(0.0, 0.1)
    single = np.column_stack([values + shift, np.full(count, 0.01), np.zeros((count, 2))])
    found = np.ones(count, np.bool_)
    found[list(lost)] = False
    sigma = np.where(found, 0.05, 0.0)
    single[~found] = 0.0
    clear_m = np.where(np.arange(count) < 0.4 * count, 10.0, 100.0)
    return Errors(np.arange(count), single, 0.5 * single, sigma, sigma, found, clear_m)


def test_the_rows_of_a_weather():
    rows = figures_of("s", "rain", [errors(seed=seed, lost=range(100)) for seed in range(5)], 0.1)
    assert [(row.mode, row.place) for row in rows] == [
        ("single", "all"),
        ("single", "clear"),
        ("memory", "all"),
        ("memory", "clear"),
    ]
    single, clear, memory, _ = rows
    assert (single.vehicles, single.pictures, clear.pictures) == (5, 20000, 12000)
    assert single.lost_share == pytest.approx(0.025)
    assert clear.lost_share == 0.0
    assert single.c0_mad_m == pytest.approx(0.1, rel=0.1)
    assert memory.c0_mad_m == pytest.approx(0.05, rel=0.1)
    assert single.c0_mad_low_m < single.c0_mad_m < single.c0_mad_high_m
    assert single.sigma_ratio == pytest.approx(2.0, rel=0.1)
    assert single.c0_p99_m == pytest.approx(0.258, rel=0.15)


def test_the_time_in_which_an_error_decays_is_found():
    series = [(one.single[:, 0], one) for one in (errors(20000, tau=12.0, seed=seed) for seed in range(3))]
    assert decay_s(series, 0.1) == pytest.approx(1.2, rel=0.1)
    series[0][0][1000] = 3.4  # a picture of the next lane
    assert decay_s(series, 0.1) == pytest.approx(1.2, rel=0.1)


def test_nothing_found_is_no_row():
    assert figures_of("s", "rain", [errors(50, lost=range(50))], 0.1) == []


def test_a_tape_has_a_piece_for_each_stretch_less_its_median(tmp_path):
    one = errors(300, shift=0.4, lost=(7,))
    moment = one.moment.copy()
    moment[100:] += 50  # inside a junction
    moment[110:] += 50
    made = tape_of([one._replace(moment=moment)], "single", "rain", 0.1, {"made_by": "a test"})
    assert made.rate_hz == pytest.approx(10.0)
    assert made.piece.tolist() == [0, 100]  # 1 s between two junctions is too short
    assert np.flatnonzero(made.missing).tolist() == [7]
    assert len(made.missing) == 290
    assert made.median[:, 0] == pytest.approx([0.4, 0.4], abs=0.1)
    for piece in (made.errors[:100][~made.missing[:100]], made.errors[100:]):
        np.testing.assert_allclose(np.median(piece, axis=0), 0.0, atol=1e-4)
    write_tape(made, tmp_path / "t.npz")


def test_the_next_lane_is_no_error_that_a_tape_keeps():
    one = errors(300)
    one.single[50:53, 0] += 3.5
    made = tape_of([one], "single", "rain", 0.1, {"made_by": "a test"})
    assert np.flatnonzero(made.missing).tolist() == [50, 51, 52]
    assert np.abs(made.errors[:, 0]).max() < 1.0


def test_an_empty_tape_is_refused():
    with pytest.raises(GpsecError, match="expected 2 s of a lane that is seen, found no such stretch"):
        tape_of([errors(50, lost=range(50))], "single", "rain", 0.1, {})
