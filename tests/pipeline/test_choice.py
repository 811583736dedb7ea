from dataclasses import replace
from math import pi, sqrt

import pytest

from gpsec.core.errors import GpsecError
from gpsec.pipeline.filter_noise import filter_noise
from gpsec.pipeline.fleet_choice import Few, FleetChoice, run_profiles
from gpsec.sensors.registry import PROFILES
from gpsec.traffic.source import Departure

N = 20_000


def departure(name: str, share: float | None = None, sensors: str | None = None) -> Departure:
    return Departure(-1, name, "car", "passenger", 4.6, 1.8, 0.0, 0.0, share, sensors)


def choice(seed: int = 3, equipped: float = 0.3, **shares: float) -> FleetChoice:
    shares = shares or {"carla": 0.9, "consumer": 0.1}
    return FleetChoice(seed, equipped, shares, (*shares, "dsd"))


def test_shares_are_met():
    """Within 4 standard errors of a binomial share."""
    fleet = [departure(f"v{i}") for i in range(N)]
    drawn = choice()
    equipped = sum(drawn.equipped(d) for d in fleet) / N
    assert abs(equipped - 0.3) < 4.0 * sqrt(0.3 * 0.7 / N)
    consumers = [d for d in fleet if drawn.profile(d) == 1]
    assert abs(len(consumers) / N - 0.1) < 4.0 * sqrt(0.1 * 0.9 / N)
    # Who is equipped says nothing about the sensors.
    both = sum(drawn.equipped(d) for d in consumers) / len(consumers)
    assert abs(both - 0.3) < 4.0 * sqrt(0.3 * 0.7 / len(consumers))


def test_a_type_says_otherwise():
    drawn = choice()
    fleet = [departure(f"v{i}", share=0.8, sensors="dsd") for i in range(N)]
    assert abs(sum(drawn.equipped(d) for d in fleet) / N - 0.8) < 4.0 * sqrt(0.8 * 0.2 / N)
    assert {drawn.profile(d) for d in fleet} == {2}
    assert not any(drawn.equipped(departure(f"v{i}", share=0.0)) for i in range(N))
    assert all(drawn.equipped(departure(f"v{i}", share=1.0)) for i in range(N))


def test_seeds_draw_differently_and_a_larger_share_keeps_who_is_equipped():
    fleet = [departure(f"v{i}") for i in range(2000)]
    some = {d.vehicle_id for d in fleet if choice().equipped(d)}
    assert some != {d.vehicle_id for d in fleet if choice(seed=4).equipped(d)}
    assert some < {d.vehicle_id for d in fleet if choice(equipped=0.6).equipped(d)}


def test_a_second_life_keeps_what_the_first_was_given():
    drawn = choice(carla=0.5, consumer=0.5)
    for i in range(200):
        first, later = departure(f"v{i}"), departure(f"v{i}#3")
        assert drawn.equipped(first) == drawn.equipped(later)
        assert drawn.profile(first) == drawn.profile(later)
    # A name that merely holds the mark is a vehicle of its own.
    assert any(drawn.profile(departure(f"v{i}#a")) != drawn.profile(departure(f"v{i}")) for i in range(200))


def test_what_sumo_itself_calls_like_a_second_life_is_a_vehicle_of_its_own():
    drawn = choice(carla=0.5, consumer=0.5)
    pairs = [(departure(f"v{i}"), replace(departure(f"v{i}#2"), sumo_id=f"v{i}#2")) for i in range(200)]
    assert any(drawn.profile(one) != drawn.profile(other) for one, other in pairs)


def test_few_are_found_by_any_of_their_names():
    drawn = Few.named(choice(equipped=1.0), ["v#2"])
    own, later, other = (
        replace(departure(name), sumo_id=sumo_id) for name, sumo_id in (("v#2", "v#2"), ("v#3", "v"), ("w", "w"))
    )
    assert [drawn.equipped(one) for one in (own, later, other)] == [True, True, False]


def test_profiles_of_a_run_are_those_of_the_configuration_first():
    assert run_profiles({"carla": 0.5, "dsd": 0.5}, {"nuscenes": "a", "dsd": "b"}) == ("carla", "dsd", "nuscenes")
    with pytest.raises(GpsecError, match=r"types\.add\.xml: vType 'bus': .*'dsdd': did you mean 'dsd'\?"):
        run_profiles({"carla": 1.0}, {"dsdd": "types.add.xml: vType 'bus'"})


def test_data_sheets_in_the_units_of_the_loop():
    """By hand for the carla profile: 0.75 °/√h, 10 °/h, fixes every 0.05 s on a step of 0.1 s."""
    noise = filter_noise(PROFILES["carla"], 0.1)
    assert noise.gyro_white_rps == pytest.approx(0.75 * pi / 180.0 / 60.0 / sqrt(0.1))
    assert noise.gyro_bias_rps == pytest.approx(10.0 / 3600.0 * pi / 180.0)
    assert noise.gnss_period_s == 0.1
    assert noise.heading_rad == pytest.approx(sqrt(0.1**2 + 0.1**2) * pi / 180.0)
    assert noise.residual_m == pytest.approx(sqrt(0.064**2 + 0.048**2 + 0.04**2 + 0.11**2 + 0.05**2))
    assert filter_noise(PROFILES["consumer"], 0.1).gnss_period_s == pytest.approx(0.2)
