"""What every registered attack must keep; a new attack needs a row in the table. The rules are in `gpsec.testing`."""

from typing import ClassVar

import numpy as np
import pytest
from pydantic import Field

from gpsec.attacks.base import Attack, NoState, Spoofed, displace_left
from gpsec.attacks.registry import ATTACKS
from gpsec.attacks.zones import zone_keys
from gpsec.testing import ATTACK_CHECKS, BrokenContractError, check_attack
from gpsec.testing.attacks import RESERVED, AttackCase, same_fixes

# With parameters that make each show all it does within two seconds.
CASES = [
    AttackCase(ATTACKS["constant_bias"]),
    AttackCase(ATTACKS["constant_bias"], {"frame": "world", "side": "as_given"}),
    AttackCase(ATTACKS["stealth"], {"gamma_m": 0.5, "cap_m": 2.0}),
    AttackCase(ATTACKS["two_stage"], {"timeout_s": 1.0, "update_s": 0.3}),
    AttackCase(ATTACKS["drift"], {"cap_m": 0.5}),
    AttackCase(ATTACKS["blind_drift"], {"rate_mps": 2.0}),
    AttackCase(ATTACKS["noise"]),
    AttackCase(ATTACKS["replay"], {"delay_s": 1.5}, denies_fixes=True),
    AttackCase(ATTACKS["jamming"], denies_fixes=True),
    AttackCase(ATTACKS["lane_alias"]),
    AttackCase(ATTACKS["lane_alias"], {"side": "right"}),
    AttackCase(ATTACKS["adaptive"]),
    AttackCase(ATTACKS["adaptive"], {"knowledge": "queries", "junctions": "move"}),
    AttackCase(ATTACKS["adaptive"], {"knowledge": "grey", "junctions": "move", "target": ("joint", "cusum")}),
]
WITH_STATE = {"two_stage", "lane_alias", "blind_drift", "adaptive"}


def test_the_table_has_every_attack() -> None:
    assert {case.kind.name for case in CASES} == set(ATTACKS)
    assert all(attack.name == name for name, attack in ATTACKS.items())


def test_names_that_zones_and_vehicles_take_are_reserved() -> None:
    assert {key.removeprefix("gpsec.") for key in zone_keys()[:5]} <= RESERVED


@pytest.mark.parametrize("check", ATTACK_CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.kind.name}{case.parameters or ''}")
def test_it_keeps_the_contract(case: AttackCase, check) -> None:
    check(case)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.kind.name}{case.parameters or ''}")
def test_what_comes_later_does_change_it_then(case: AttackCase) -> None:
    """The look for later data would notice: what follows from step 45 on differs, but where no fixes are left."""
    differs = not same_fixes(case.answers(), case.answers(case.world.change_from(45)))
    assert differs == (case.kind.name != "jamming")
    assert (case.kind.state is NoState) == (case.kind.name not in WITH_STATE)


class Good(Attack):
    """A bias to the left.

    Attributes:
        bias_m: how far.
    """

    name: ClassVar[str] = "good"
    bias_m: float = Field(2.0, ge=0.5, le=50.0)

    def spoof(self, victims, state):
        return displace_left(victims, np.full(len(victims.rows), self.bias_m))


class Unbounded(Good):
    bias_m: float = 2.0


class Undocumented(Good):
    strength: float = Field(2.0, ge=0.5, le=50.0)


class Reserved(Good):
    """Attributes: share: how much."""

    share: float = Field(2.0, ge=0.5, le=50.0)


class Writes(Good):
    def spoof(self, victims, state):
        victims.fix_m[:] += self.bias_m
        return Spoofed(victims.fix_m, victims.fix_valid)


class Invents(Good):
    def spoof(self, victims, state):
        return Spoofed(victims.fix_m + self.bias_m, np.ones(len(victims.rows), np.bool_))


class Denies(Good):
    def spoof(self, victims, state):
        return Spoofed(victims.fix_m.copy(), victims.fix_valid & False)


class Idle(Good):
    def spoof(self, victims, state):
        return Spoofed(victims.fix_m.copy(), victims.fix_valid.copy())


class Random(Good):
    def spoof(self, victims, state):
        return Spoofed(
            victims.fix_m + np.random.default_rng().normal(size=(len(victims.rows), 2)), victims.fix_valid.copy()
        )


class Crowd(Good):
    def spoof(self, victims, state):
        return displace_left(victims, np.full(len(victims.rows), self.bias_m + len(victims.rows)))


class LooksBack(Good):
    def spoof(self, victims, state):
        past_m, exists = victims.past_fix(1.0)
        return Spoofed(past_m.copy(), victims.fix_valid & exists)


class NotANumber(Good):
    def spoof(self, victims, state):
        return Spoofed(
            np.where(victims.fix_valid[:, np.newaxis], victims.fix_m + self.bias_m, np.nan), victims.fix_valid.copy()
        )


def test_an_attack_that_keeps_the_contract_passes() -> None:
    check_attack(Good, bias_m=1.0)
    check_attack(ATTACKS["replay"], denies_fixes=True, delay_s=1.5)


@pytest.mark.parametrize(
    ("kind", "rule"),
    [
        (Unbounded, "lower and an upper bound"),
        (Undocumented, "strength: a parameter has a line"),
        (Reserved, "share: this name is taken"),
        (Writes, "left alone"),
        (Invents, "no spoofed fix where there is no honest one"),
        (Denies, "say `denies_fixes`"),
        (Idle, "moved by more than a centimetre"),
        (Random, "draw from gpsec.core.noise"),
        (Crowd, "in whatever company"),
        (LooksBack, "needed_memory_s"),
        (NotANumber, "finite"),
    ],
)
def test_an_attack_that_breaks_a_rule_is_told_which(kind: type[Attack], rule: str) -> None:
    with pytest.raises(BrokenContractError, match=rule):
        check_attack(kind)
