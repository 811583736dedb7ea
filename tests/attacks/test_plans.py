"""Plans as a user writes them: what is taken, and what is refused in which words."""

import json
import tomllib

import pytest

from gpsec.attacks.plans import PlanConfig, plan_config
from gpsec.attacks.registry import ATTACKS, build_attack
from gpsec.attacks.stealth import Stealth
from gpsec.core.errors import GpsecError

WHERE = "town/gpsec.toml: plans[0]"


def from_toml(text: str) -> PlanConfig:
    return plan_config(tomllib.loads("[[plans]]\n" + text)["plans"][0], WHERE)


def test_parameters_stand_beside_the_plans_own_keys() -> None:
    config = from_toml('attack = "stealth"\nshare = 1\nduration_s = [5, 8.5]\ngamma_m = 0.5\nvehicle_types = ["van"]')
    assert (config.name, config.share, config.duration_s) == ("stealth", 1.0, (5.0, 8.5))
    assert config.vehicle_types == ("van",)
    assert config.parameters == Stealth(gamma_m=0.5)


def test_parameters_may_have_a_table_of_their_own() -> None:
    assert from_toml('attack = "drift"\n[plans.parameters]\nrate_mps = 0.5') == from_toml(
        'attack = "drift"\nrate_mps = 0.5'
    )


@pytest.mark.parametrize("name", ATTACKS)
def test_every_attack_is_a_plan_by_its_name_alone(name: str) -> None:
    config = plan_config({"attack": name}, WHERE)
    assert config.name == name
    assert config.parameters == ATTACKS[name]()
    assert set(config.model_dump()["parameters"]) == set(ATTACKS[name].model_fields)


def test_a_plan_survives_json() -> None:
    for config in (
        from_toml('attack = "two_stage"\nname = "ripper"\nf = 1.2\nend_s = 60'),
        from_toml('attack = "jamming"\nzone = "tunnel"'),
    ):
        text = json.dumps(config.model_dump(mode="json"), allow_nan=False)
        assert PlanConfig.model_validate(json.loads(text)) == config


REFUSED = [
    ('attack = "stelth"', "unknown attack 'stelth': did you mean 'stealth'?"),
    ("share = 0.5", "attack: expected one of constant_bias, stealth,"),
    ("attack = 3", "attack: expected a valid string, found 3"),
    ('attack = "stealth"\ngama_m = 1', "unknown key 'gama_m' for attack 'stealth': did you mean 'gamma_m'?"),
    ('attack = "stealth"\nshares = 1', "unknown key 'shares' for attack 'stealth': did you mean 'share'?"),
    ('attack = "jamming"\nbias_m = 1.0', "unknown key 'bias_m' for attack 'jamming':"),
    ('attack = "stealth"\ngamma_m = -1.5', "gamma_m: expected a number greater than 0, found -1.5"),
    ('attack = "stealth"\ngamma_m = "big"', "gamma_m: expected a valid number, found 'big'"),
    ('attack = "stealth"\ngamma_m = true', "gamma_m: expected a valid number, found True"),
    ('attack = "stealth"\ngamma_m = nan', "gamma_m: expected a finite number, found nan"),
    ('attack = "drift"\nrate_mps = 0.6', "rate_mps: expected a number less than or equal to 0.5, found 0.6"),
    ('attack = "drift"\nframe = "road"', "frame: expected 'lane' or 'world', found 'road'"),
    ('attack = "drift"\nshare = 1.2', "share: expected a number less than or equal to 1, found 1.2"),
    ('attack = "drift"\nshare = "half"', "share: expected a valid number, found 'half'"),
    ('attack = "drift"\nname = ""', "name: expected at least 1 character, found ''"),
    ('attack = "drift"\nname = "none"', "name: 'none' is kept for vehicles without an attack"),
    ('attack = "drift"\nvehicle_types = "car"', "vehicle_types: expected a list, found 'car'"),
    ('attack = "drift"\nduration_s = 20', "duration_s: expected [least, most] in seconds"),
    ('attack = "drift"\nduration_s = [20, 10]', "0 <= least <= most, found [20, 10]"),
    ('attack = "drift"\nstart_after_s = [-1, 10]', "start_after_s: expected [least, most] in seconds"),
    ('attack = "drift"\nstart_after_s = [0, inf]', "start_after_s: expected [least, most] in seconds"),
    ('attack = "drift"\nstart_after_s = [true, 2]', "start_after_s: expected [least, most] in seconds"),
    ('attack = "drift"\nbegin_s = 60\nend_s = 60', "end_s: expected later than begin_s = 60, found 60"),
    ('attack = "drift"\nend_s = inf', "end_s: expected a finite number, found inf"),
    ('attack = "drift"\nzone = "a"\nduration_s = [1, 2]', "duration_s: expected none beside a zone"),
    ('attack = "drift"\nparameters = 3', "parameters: expected a table, found 3"),
    ('attack = "drift"\ncap_m = 1\nparameters = {cap_m = 1}', "key 'cap_m' stands in the plan and in its parameters"),
]


@pytest.mark.parametrize(("text", "problem"), REFUSED, ids=[text.replace("\n", ", ") for text, _ in REFUSED])
def test_a_bad_plan_is_refused_in_one_sentence(text: str, problem: str) -> None:
    with pytest.raises(GpsecError) as caught:
        from_toml(text)
    assert str(caught.value).startswith(f"{WHERE}: ")
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


def test_text_stands_for_numbers_only_where_the_file_has_nothing_else() -> None:
    assert build_attack("stealth", {"gamma_m": "0.5"}, "zone", as_text=True) == Stealth(gamma_m=0.5)
    with pytest.raises(GpsecError, match=r"gamma_m: expected a valid number, found '0\.5'"):
        build_attack("stealth", {"gamma_m": "0.5"}, "plan")
