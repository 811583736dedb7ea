"""All attacks by name, and how an attack is made from what a user wrote."""

from collections.abc import Iterable, Mapping

from pydantic import ValidationError

from gpsec.attacks.adaptive import Adaptive
from gpsec.attacks.base import Attack
from gpsec.attacks.blind_drift import BlindDrift
from gpsec.attacks.constant_bias import ConstantBias
from gpsec.attacks.drift import Drift
from gpsec.attacks.jamming import Jamming
from gpsec.attacks.lane_alias import LaneAlias
from gpsec.attacks.noise import Noise
from gpsec.attacks.replay import Replay
from gpsec.attacks.stealth import Stealth
from gpsec.attacks.two_stage import TwoStage
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.registry import Registry, subclass_named

_OWN: tuple[type[Attack], ...] = (
    ConstantBias,
    Stealth,
    TwoStage,
    Drift,
    BlindDrift,
    Noise,
    Replay,
    Jamming,
    LaneAlias,
    Adaptive,
)
ATTACKS: Registry[type[Attack]] = Registry(
    "attack", "gpsec.attacks", {attack.name: attack for attack in _OWN}, subclass_named(Attack)
)


def build_attack(
    name: str,
    parameters: Mapping[str, object],
    where: str,
    *,
    prefix: str = "",
    other_keys: Iterable[str] = (),
    as_text: bool = False,
) -> Attack:
    """Return the attack `name` with those parameters.

    Args:
        name: of the attack.
        parameters: its parameters by their own names; those that are missing keep their defaults.
        where: what the parameters stand in, for error messages: a file and a key or row.
        prefix: what the file puts before the name of a parameter.
        other_keys: keys that may stand beside the parameters there, for *did you mean*.
        as_text: values are strings that stand for numbers and choices.

    Raises:
        GpsecError: the attack or a parameter is unknown, or a value is not allowed.
    """
    if name not in ATTACKS:
        raise GpsecError(f"{where}: unknown attack '{shown(name)}': {nearest(name, ATTACKS)}")
    kind = ATTACKS[name]
    for key in parameters:
        if key not in kind.model_fields:
            known = [*(prefix + field for field in kind.model_fields), *other_keys]
            raise GpsecError(
                f"{where}: unknown key '{shown(prefix + key)}' for attack '{shown(name)}': "
                f"{nearest(prefix + key, known)}"
            )
    try:
        if as_text:
            return kind.model_validate_strings(dict(parameters))
        return kind.model_validate(dict(parameters))
    except ValidationError as error:
        raise GpsecError(f"{where}: {first_problem(error, prefix)}") from None


def first_problem(error: ValidationError, prefix: str = "") -> str:
    """Return the first thing that is wrong: the key, what was expected and what was found."""
    detail = error.errors(include_url=False)[0]
    key = prefix + ".".join(str(part) for part in detail["loc"])
    if detail["type"] == "value_error":  # one of ours, a whole sentence
        problem = str(detail["ctx"]["error"])
        return f"{key}: {problem}" if detail["loc"] else problem
    if detail["type"] == "missing":
        return f"{key}: expected a value, found none"
    expected = detail["msg"].removeprefix("Input should be ").removeprefix("String should have ")
    expected = expected.replace("valid tuple", "list")
    if expected.startswith(("greater", "less")):
        expected = f"a number {expected}"
    return f"{key}: expected {expected}, found {repr(detail['input'])[:60]}"
