"""The smooth wander of fixes: its equations, its steps, and `consumer` beside real logs."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import quad

from gpsec.core.threads import Threads
from gpsec.sensors.profiles import Gnss
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.shared_errors import SharedErrors
from gpsec.sensors.smooth import Wander
from gpsec.testing.drive import Drive
from tests.sensors.exact import profile

CONSUMER_GNSS = PROFILES["consumer"].gnss
# √structure function of a real receiver across the way, in m at these lags in s: 11,561 fixes (docs/sensors.md).
REAL = {0.1: 0.003, 1.0: 0.014, 5.0: 0.055, 10.0: 0.093, 30.0: 0.16, 120.0: 0.24}
WANDER = {"wander_mps": 0.015, "wander_tau_s": 3.0, "wander_hold_s": 50.0}


def consumer(**changes):
    """Exact sensors with the receiver of `consumer` at 10 Hz, without latency and outages."""
    always = {"rate_hz": 10.0, "latency_s": 0.0, "outages_per_h": 0.0, "outage_mean_s": 0.0}
    figures = {key: value for key, value in CONSUMER_GNSS.figures().items() if key != "sources"}
    return profile(gnss=figures | always | changes)


def errors(steps: int, vehicles: int, seed: int = 1, **changes) -> np.ndarray:
    """Return (S, N, 2) errors of the fixes of standing vehicles, with what they share."""
    fleet = Drive((consumer(**changes),), vehicles, seed=seed)
    around = SharedErrors(fleet.sensors, seed)
    state, found = around.new_state(), []
    for step in range(steps):
        seen = fleet.sense()
        around.disturb(state.now, fleet.rows, step, fleet.vehicles, seen)
        found.append(seen.fix_m.copy())
    return np.array(found)


@pytest.mark.parametrize("lag_s", [0.0, 1.0, 20.0])
def test_the_covariance_is_that_of_the_spectrum(lag_s):
    """R(t) = (1/π)·∫ S(ω) cos(ωt) dω over ω > 0, with S of two filters in a row."""
    wander = Wander(0.015, 3.0, 50.0)
    a, b = 1.0 / 50.0, 1.0 / 3.0

    def spectrum(omega: float) -> float:
        return 2.0 * 0.015**2 * b / ((omega**2 + a**2) * (omega**2 + b**2))

    cut = 50.0
    summed = (
        quad(spectrum, 0.0, cut, weight="cos", wvar=lag_s, limit=500)[0]
        if lag_s
        else quad(spectrum, 0.0, cut, limit=500)[0]
    )
    assert wander.covariance_m2(np.array([lag_s]))[0] == pytest.approx(summed / np.pi, rel=1e-4)
    assert wander.sigma_m**2 == pytest.approx(wander.covariance_m2(np.zeros(1))[0])


def test_a_short_way_is_rate_times_time():
    """Of the rate r less what the leak takes, p/T, the variance is σ²·b/(a + b)."""
    wander = Wander(0.02, 5.0, 100.0)
    expected = 0.02 * np.sqrt(0.2 / (0.01 + 0.2)) * 0.01
    assert np.sqrt(wander.structure_m2(np.array([0.01])))[0] == pytest.approx(expected, rel=0.002)


def test_steps_have_the_structure_function_of_the_equation():
    found = errors(1500, 1000, white_m=0.0, common_share=0.5)[..., 0]
    wander = Wander(**{"rate_mps": 0.015, "rate_tau_s": 3.0, "hold_s": 50.0})
    for lag in (1, 10, 50, 300):
        # What is shared is a single draw; what vehicles have of their own is half of the variance.
        own = found - found.mean(axis=1, keepdims=True)
        measured = np.mean((own[lag:] - own[:-lag]) ** 2) * 1000 / 999
        assert measured == pytest.approx(0.5 * wander.structure_m2(np.array([0.1 * lag]))[0], rel=0.07)


def test_it_begins_as_it_is_in_the_long_run():
    found = errors(600, 2000, white_m=0.0, common_share=1e-9)[..., 1]
    assert found[0].std() == pytest.approx(1.05, rel=0.06)
    assert found[-1].std() == pytest.approx(found[0].std(), rel=0.05)
    assert (found[300:] - found[:-300]).std() == pytest.approx(
        np.sqrt(Wander(0.015, 3.0, 50.0).structure_m2(np.array([30.0])))[0], rel=0.05
    )


def test_consumer_is_as_smooth_as_a_real_receiver():
    """√structure within ± 30 % of the real one from 0.1 to 120 s, and from fix to fix at most 0.01 m."""
    for lag_s, real_m in REAL.items():
        assert np.sqrt(CONSUMER_GNSS.structure_m2(lag_s)) == pytest.approx(real_m, rel=0.3)
    found = np.concatenate([errors(1300, 1, seed)[:, 0] for seed in range(40)], axis=1)
    for lag_s, real_m in REAL.items():
        lag = round(10.0 * lag_s)
        measured = np.sqrt(np.mean((found[lag:] - found[:-lag]) ** 2))
        assert measured == pytest.approx(real_m, rel=0.3), lag_s
    assert np.sqrt(np.mean(np.diff(found, axis=0) ** 2)) <= 0.01


def test_two_vehicles_share_four_fifths_of_the_variance():
    """0.8 ± 0.1, whatever is between them: one kilometre."""
    pairs = np.array([errors(1, 2, seed)[0] for seed in range(600)])
    for axis in range(2):
        assert np.corrcoef(pairs[:, 0, axis], pairs[:, 1, axis])[0, 1] == pytest.approx(0.8, abs=0.1)
        assert pairs[:, 0, axis].std() == pytest.approx(1.05, rel=0.1)


def test_the_same_bits_for_two_threads_and_any_batch(monkeypatch):
    monkeypatch.setattr(Threads, "MIN_ROWS", 4)
    found = []
    for count in (1, 2):
        fleet, threads = Drive((consumer(), profile("other")), 40), Threads(count)
        found.append([fleet.sense(threads=threads).fix_m.tobytes() for _ in range(30)])
        threads.close()
    assert found[0] == found[1]


def test_a_profile_without_a_wander_is_as_before():
    """Beside one with a wander, to the last bit."""
    plain = {"white_m": 0.2, "bias_m": 1.0, "bias_tau_s": 50.0}
    alone, beside = (
        Drive((profile(gnss=plain),), 4),
        Drive((profile(gnss=plain), consumer().model_copy(update={"name": "c"})), 4),
    )
    beside.vehicles.profile[:] = 0
    for fleet in (alone, beside):
        fleet.sensors.enter(fleet.state, fleet.vehicles, fleet.rows, 0)
    for _ in range(20):
        assert (alone.sense().fix_m == beside.sense().fix_m).all()


@pytest.mark.parametrize(
    ("figures", "said"),
    [
        ({"wander_mps": 0.015}, "expected wander_mps, wander_tau_s, wander_hold_s together, found wander_mps"),
        (WANDER | {"bias_m": 0.1}, r"expected wander and multipath within bias_m = 0\.1 m, found 0\.178 m"),
        (WANDER | {"wander_tau_s": 0.0}, "greater than 0"),
    ],
)
def test_a_wander_that_is_none_is_refused(figures, said):
    with pytest.raises(ValidationError, match=said):
        profile(gnss=figures | {"bias_m": figures.get("bias_m", 1.0)})


def test_its_figures_need_sources():
    with pytest.raises(ValidationError, match="no source given for common_share"):
        Gnss(
            **{
                **CONSUMER_GNSS.model_dump(),
                "sources": {k: v for k, v in CONSUMER_GNSS.sources.items() if k != "common_share"},
            }
        )
