"""What a search for the worst attack may choose: parameters of one attack, each within bounds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from gpsec.attacks.plans import PlanConfig, plan_config
from gpsec.attacks.registry import ATTACKS
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.outcomes.tables import FLOAT_FORMAT

# Bounds whose quotient is larger are searched by orders of magnitude.
_MANY_TIMES = 10.0
# Keys of a plan that say when and who, and that every plan of a search has in common.
_COMMON = ("share", "vehicle_types", "vehicles", "begin_s", "end_s", "start_after_s", "duration_s")


@dataclass(frozen=True)
class Free:
    """A parameter that is searched.

    Attributes:
        name: of the parameter.
        low, high: bounds of a number, both of them allowed.
        choices: texts, where it is not a number.
        whole: only whole numbers.
    """

    name: str
    low: float = 0.0
    high: float = 0.0
    choices: tuple[str, ...] = ()
    whole: bool = False

    def distribution(self, optuna: ModuleType) -> Any:
        """Return what Optuna draws values from."""
        kinds = optuna.distributions
        if self.choices:
            return kinds.CategoricalDistribution(self.choices)
        log = self.low > 0.0 and self.high / self.low >= _MANY_TIMES
        if self.whole:
            return kinds.IntDistribution(int(self.low), int(self.high), log=log)
        return kinds.FloatDistribution(self.low, self.high, log=log)

    @property
    def ends(self) -> tuple[Any, ...]:
        """The bounds, or all choices."""
        return self.choices or ((int(self.low), int(self.high)) if self.whole else (self.low, self.high))


@dataclass(frozen=True)
class Space:
    """What is searched.

    Attributes:
        attack: name of the attack.
        free: parameters that are searched.
        fixed: other keys of the plans.
    """

    attack: str
    free: tuple[Free, ...]
    fixed: Mapping[str, Any]

    def plan(self, name: str, values: Mapping[str, Any]) -> PlanConfig:
        """Return the plan with those values of the free parameters; without some, they have their defaults.

        Raises:
            GpsecError: a value is not allowed.
        """
        return plan_config({"attack": self.attack, "name": name, **self.fixed, **values}, f"attack '{self.attack}'")

    def distributions(self, optuna: ModuleType) -> dict[str, Any]:
        """Return what Optuna draws the free parameters from."""
        return {one.name: one.distribution(optuna) for one in self.free}


def make_space(attack: str, free: Sequence[str], fixed: Mapping[str, Any]) -> Space:
    """Return what is searched, checked.

    Args:
        attack: name of the attack.
        free: such as ``bias_m=0.5:15`` or ``junctions=hold,move``.
        fixed: keys of its plans, such as ``duration_s`` or a parameter of the attack.

    Raises:
        GpsecError: there is no such attack or parameter, none is free, or bounds exclude each other or are not allowed.
    """
    if attack not in ATTACKS:
        raise GpsecError(f"--attack: unknown attack '{shown(attack)}': {nearest(attack, ATTACKS)}")
    own = ATTACKS[attack].model_fields
    if not own:
        raise GpsecError(f"--attack {attack}: expected an attack with parameters, found one without")
    if not free:
        raise GpsecError(f"--free: expected at least one parameter of '{attack}' ({', '.join(own)}), found none")
    for key in fixed:
        if key not in own and key not in _COMMON:
            raise GpsecError(f"--fix {shown(key)}: unknown key: {nearest(key, [*own, *_COMMON])}")
    parsed = tuple(_free(text, attack) for text in free)
    names = [one.name for one in parsed]
    for name in names:
        if names.count(name) > 1 or name in fixed:
            raise GpsecError(f"--free {name}: expected each parameter once, free or fixed, found it twice")
    space = Space(attack, parsed, fixed)
    space.plan("default", {})
    for one in parsed:
        for end in one.ends:
            space.plan("bound", {one.name: end})
    return space


def _free(text: str, attack: str) -> Free:
    name, equals, bounds = text.partition("=")
    own = ATTACKS[attack].model_fields
    if name not in own:
        raise GpsecError(f"--free {shown(text)}: '{attack}' has no such parameter: {nearest(name, own)}")
    where = f"--free {shown(text)}"
    kind = own[name].annotation
    if kind not in (float, int):
        choices = tuple(one.strip() for one in bounds.split(","))
        if not equals or len(set(choices)) < 2 or not all(choices):
            raise GpsecError(
                f"{where}: expected two or more choices, such as {name}=one,other, found '{shown(bounds)}'"
            )
        return Free(name, choices=choices)
    low, colon, high = bounds.partition(":")
    try:
        ends = float(low), float(high)
    except ValueError:
        ends = (float("nan"), float("nan"))
    if not colon or not all(abs(end) < float("inf") for end in ends):
        raise GpsecError(f"{where}: expected two numbers, such as {name}=1:2, found '{shown(bounds)}'")
    ends = float(FLOAT_FORMAT % ends[0]), float(FLOAT_FORMAT % ends[1])
    if ends[0] >= ends[1]:
        raise GpsecError(f"{where}: expected a lower bound below the upper one, found {ends[0]:g} and {ends[1]:g}")
    return Free(name, *ends, whole=kind is int)
