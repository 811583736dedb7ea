"""Attacks that vehicles carry, as plans; and what is refused in which words."""

from pathlib import Path

import numpy as np
import pytest

from gpsec.attacks.drift import Drift
from gpsec.attacks.plans import MAX_TIME_S
from gpsec.attacks.vehicle_plans import plans_from_vehicles
from gpsec.core.errors import GpsecError
from gpsec.types.attack_inputs import CarriedAttack


def carried(element: str = "vType", owner: str = "van", /, *, file: str = "a.rou.xml", **given: str) -> CarriedAttack:
    """Return what the element of that id carries: a drift, unless another attack is given."""
    parameters = {"gpsec.attack": "drift"} | {f"gpsec.{key}": value for key, value in given.items()}
    return CarriedAttack(Path(file), element, owner, parameters)


def drift(**others: str) -> dict[str, str]:
    return {"gpsec.attack": "drift"} | {f"gpsec.{key}": value for key, value in others.items()}


def test_a_spoofer_reaches_as_far_as_was_published_and_spares_nobody() -> None:
    [(config, zone, where)] = plans_from_vehicles([carried()])
    assert (config.name, config.zone, config.share, config.vehicles) == ("van", "van", 1.0, ())
    assert (config.begin_s, config.end_s) == (0.0, None)
    assert config.parameters == Drift()
    assert zone is not None
    assert zone.moves
    assert (zone.zone_id, zone.hold_s) == ("van", 3.0)
    assert 40.0 <= zone.radius_m <= 50.0
    assert where == "a.rou.xml: vType 'van'"


def test_a_spoofer_that_says_everything() -> None:
    said = {"radius_m": "30", "hold_s": "0", "begin": "5", "end": "60", "share": "0.5", "direction_deg": "0"}
    [(config, zone, _)] = plans_from_vehicles([carried(**said, rate_mps="0.3", plan="two")])
    assert (config.name, config.begin_s, config.end_s, config.share) == ("two", 5.0, 60.0, 0.5)
    assert config.parameters == Drift(rate_mps=0.3, direction_deg=0.0)
    assert zone is not None
    assert (zone.radius_m, zone.hold_s) == (30.0, 0.0)
    position = np.array([[0.0, 0.0], [30.0, 0.0], [30.1, 0.0], [70.0, 0.0]])
    spoofers = {"two": np.array([[0.0, 0.0], [100.0, 0.0]]), "van": np.array([[30.1, 0.0]])}
    assert zone.contains(position, spoofers).tolist() == [True, True, False, True]
    assert not zone.contains(position, {}).any()


def test_a_vehicle_that_is_attacked_itself_is_from_when_it_has_settled() -> None:
    [(config, zone, _)] = plans_from_vehicles([carried("flow", "east", begin="20")])
    assert zone is None
    assert (config.name, config.vehicles, config.begin_s) == ("east", ("east.*",), 20.0)
    assert (config.start_after_s, config.duration_s) == ((0.0, 0.0), (MAX_TIME_S, MAX_TIME_S))


def test_those_that_state_the_same_plan_are_one() -> None:
    who = (("vehicle", "a"), ("flow", "b"), ("trip", "c"))
    members = [carried(element, owner, plan="p") for element, owner in who]
    alone = carried("vehicle", "d")
    plans = plans_from_vehicles([members[0], alone, *members[1:]])
    assert [(config.name, config.vehicles) for config, _, _ in plans] == [("p", ("a", "b.*", "c")), ("d", ("d",))]


REFUSED = {
    "no attack": ({"gpsec.attack": " "}, r"gpsec\.attack: expected one of constant_bias, .*, found none"),
    "unknown attack": (drift() | {"gpsec.attack": "drft"}, r"gpsec\.attack: unknown attack 'drft': did you mean 'drif"),
    "unknown key": (
        drift(radius="9"),
        r"unknown key 'gpsec\.radius' for attack 'drift': did you mean 'gpsec\.radius_m",
    ),
    "another attack's": (drift(bias_m="9"), r"unknown key 'gpsec\.bias_m' for attack 'drift'"),
    "reach of no number": (drift(radius_m="far"), r"gpsec\.radius_m: expected a number, found 'far'"),
    "no reach": (drift(radius_m="0"), r"gpsec\.radius_m: expected a number greater than 0, found 0"),
    "endless reach": (drift(radius_m="1e9"), r"gpsec\.radius_m: expected at most 1e\+06 metres"),
    "negative hold": (drift(hold_s="-1"), r"gpsec\.hold_s: expected seconds from 0 to 600, found -1"),
    "share": (drift(share="2"), r"gpsec\.share: expected a number from 0 to 1, found 2"),
    "end before begin": (drift(begin="9", end="5"), r"gpsec\.end: expected later than gpsec\.begin = 9, found 5"),
    "the attack's own": (drift(rate_mps="fast"), r"gpsec\.rate_mps: .* found 'fast'"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name: str) -> None:
    parameters, says = REFUSED[name]
    with pytest.raises(GpsecError, match=r"^a\.rou\.xml: vType 'van': " + says):
        plans_from_vehicles([CarriedAttack(Path("a.rou.xml"), "vType", "van", parameters)])


def test_a_hold_is_for_spoofers_only() -> None:
    with pytest.raises(GpsecError, match=r"unknown key 'gpsec\.hold_s' for attack 'drift'"):
        plans_from_vehicles([carried("vehicle", "v", hold_s="1")])


def test_those_of_one_plan_must_say_the_same() -> None:
    first = carried(plan="p", file="one")
    other = carried(plan="p", file="two", share="0.5")
    with pytest.raises(
        GpsecError, match=r"^two: vType 'van': gpsec\.share: expected the same as in one.* found '0\.5'"
    ):
        plans_from_vehicles([first, other])
    attacked = carried("vehicle", "v", plan="p", file="two")
    with pytest.raises(GpsecError, match=r"^two: vehicle 'v': gpsec\.plan: expected a plan of its own"):
        plans_from_vehicles([first, attacked])
