from math import exp, pi, sqrt

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.sensors.sense import Sensors
from gpsec.sensors.table import (
    BIAS,
    DECAY,
    HALF_VIEW,
    KICK,
    LATENCY,
    OUTAGE_BEGIN,
    OUTAGE_END,
    TICKS,
    angle_random_walk_rps,
    pack,
)
from tests.sensors.exact import profile


def test_angle_random_walk_gives_back_the_angle_after_an_hour():
    # n steps of dt, each σ·dt of angle, add up to σ·dt·√n; after an hour that is ARW degrees.
    step_s, hour = 0.1, 36_000
    angle_deg = angle_random_walk_rps(0.75, step_s) * step_s * sqrt(hour) * 180.0 / pi
    assert angle_deg == pytest.approx(0.75, rel=1e-12)


def test_bias_keeps_its_variance_and_forgets_with_its_time_constant():
    table = pack([profile(gnss={"bias_m": 2.0, "bias_tau_s": 5.0})], 0.1).gnss[0]
    assert table[DECAY] == pytest.approx(exp(-0.02), rel=1e-15)
    assert (table[DECAY] * 2.0) ** 2 + table[KICK] ** 2 == pytest.approx(4.0, rel=1e-14)


def test_units_become_si():
    table = pack([profile(gyro={"bias_deg_per_h": 3.6}, camera={"field_of_view_deg": 90.0})], 0.1)
    assert table.gyro[0, BIAS] == pytest.approx(0.001 * pi / 180.0, rel=1e-14)
    assert table.camera[0, HALF_VIEW] == pytest.approx(pi / 4.0, rel=1e-15)


def test_rates_above_the_loop_s_are_one_sample_a_step():
    def ticks(rate_hz):
        return pack([profile(gnss={"rate_hz": rate_hz})], 0.1).gnss[0, TICKS]

    assert [ticks(rate) for rate in (100.0, 10.0, 4.0)] == pytest.approx([1.0, 1.0, 0.4])
    # 1/0.07 Hz at 0.07 s: the product may fall short of 1 by a bit.
    assert pack([profile(gnss={"rate_hz": 1.0 / 0.07})], 0.07).gnss[0, TICKS] == 1.0


def test_outages_are_probabilities_per_step():
    row = pack([profile(camera={"outages_per_h": 36.0, "outage_mean_s": 1.0})], 0.1).camera[0]
    assert row[OUTAGE_BEGIN] == pytest.approx(1.0 - exp(-0.001), rel=1e-12)
    assert row[OUTAGE_END] == pytest.approx(1.0 - exp(-0.1), rel=1e-12)
    assert pack([profile(camera={"outages_per_h": 36.0})], 0.1).camera[0, OUTAGE_END] == 1.0


def test_one_row_a_profile_in_their_order():
    table = pack([profile("a", gnss={"latency_s": 0.25}), profile("b")], 0.1)
    assert {len(array) for array in table} == {2}
    np.testing.assert_allclose(table.gnss[:, LATENCY], [2.5, 0.0])


@pytest.mark.parametrize(
    ("profiles", "message"),
    [
        ((), "expected at least one sensor profile, found none"),
        ((profile("twice"), profile("twice")), "found 'twice' 2 times"),
    ],
)
def test_what_cannot_be_modelled_is_refused(profiles, message):
    with pytest.raises(GpsecError, match=message):
        Sensors(profiles, 0.1)


def test_a_step_length_of_zero_is_refused():
    with pytest.raises(GpsecError, match="positive step length, found 0 s"):
        Sensors((profile(),), 0.0)
