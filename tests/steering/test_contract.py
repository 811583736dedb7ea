"""What all lateral dynamics and reactions must keep; a new one needs a row in the table."""

from typing import ClassVar

import numpy as np
import pytest
from pydantic import Field

from gpsec.steering.base import Conduct, Follow, Moved, Nothing, Reaction
from gpsec.steering.registry import DYNAMICS, REACTIONS
from gpsec.steering.second_order import SecondOrder
from gpsec.testing import STEERING_CHECKS, BrokenContractError, check_dynamics, check_reaction
from gpsec.testing.steering import SteeringCase

CASES = [
    SteeringCase(DYNAMICS["second_order"]),
    SteeringCase(REACTIONS["continue"]),
    SteeringCase(REACTIONS["stop"], {"hold_s": 1.0}),
    SteeringCase(REACTIONS["pull_over"], {"hold_s": 1.0}),
    SteeringCase(REACTIONS["handover"], {"hold_s": 1.0, "mrm_after_s": 2.0}),
]


def test_the_table_has_all_of_them() -> None:
    assert {case.kind.name for case in CASES} == {*DYNAMICS, *REACTIONS}


@pytest.mark.parametrize("check", STEERING_CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.kind.name)
def test_it_keeps_the_contract(case: SteeringCase, check) -> None:
    check(case)


class Good(SecondOrder):
    """It moves.

    Attributes:
        haste: of it.
    """

    name: ClassVar[str] = "good"
    haste: float = Field(1.0, ge=0.5, le=2.0)


class Unbounded(Good):
    haste: float = 1.0


class Undocumented(Good):
    zeal: float = Field(1.0, ge=0.5, le=2.0)


class Crowd(Good):
    def move(self, motion, state):
        moved = super().move(motion, state)
        return Moved(moved.offset_m + 1e-9 * len(motion.rows) * (motion.speed_mps > 0.0), moved.rate_mps)


class Random(Good):
    def move(self, motion, state):
        moved = super().move(motion, state)
        shaken = 1e-6 * np.random.default_rng().normal(size=len(motion.rows)) * (motion.speed_mps > 0.0)
        return Moved(moved.offset_m + shaken, moved.rate_mps)


class Writes(Good):
    def move(self, motion, state):
        motion.rate_mps[:] = 0.0
        return super().move(motion, state)


class Shapeless(Good):
    def move(self, motion, state):
        return Moved(np.zeros(1), motion.rate_mps)


class Lazy(Good):
    def move(self, motion, state):
        return Moved(motion.offset_m.copy(), motion.rate_mps.copy())


class Nervous(Reaction):
    """It always brakes."""

    name: ClassVar[str] = "nervous"

    def react(self, situation, state: Nothing):
        count = len(situation.rows)
        return Conduct(np.full(count, Follow.LANE, np.int32), np.ones(count))


class Odd(Nervous):
    def react(self, situation, state):
        count = len(situation.rows)
        return Conduct(np.full(count, 9, np.int32), np.zeros(count))


def test_a_good_one_passes() -> None:
    check_dynamics(Good, haste=2.0)


@pytest.mark.parametrize(
    ("kind", "rule"),
    [
        (Unbounded, "haste: a number"),
        (Undocumented, "zeal: a parameter has a line"),
        (Crowd, "in whatever company"),
        (Random, "the same input"),
        (Writes, "`rate_mps` is left alone"),
        (Shapeless, "offset_m must be"),
        (Lazy, "within 30 s"),
    ],
)
def test_dynamics_that_break_a_rule_are_told_so(kind, rule) -> None:
    with pytest.raises(BrokenContractError, match=rule):
        check_dynamics(kind)


@pytest.mark.parametrize(("kind", "rule"), [(Nervous, "without an alarm"), (Odd, "one of `Follow`")])
def test_reactions_that_break_a_rule_are_told_so(kind, rule) -> None:
    with pytest.raises(BrokenContractError, match=rule):
        check_reaction(kind)
