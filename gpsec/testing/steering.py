"""The contracts of lateral dynamics and of reactions: `check_dynamics` and `check_reaction` hold all of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.steering.base import Follow, LateralDynamics, LateralMotion, Reaction, Situation
from gpsec.testing.contract import STEP_S, require

_STEPS, _VEHICLES = 120, 7
_ROWS = np.arange(_VEHICLES, dtype=np.int32)
TwoArrays = tuple[np.ndarray, np.ndarray]


def motions() -> list[LateralMotion]:
    """Return what dynamics are given: 12 s of seven vehicles that want to be elsewhere, at 1 to 30 m/s; one stands."""
    rng = np.random.default_rng(1)
    speed = rng.uniform(1.0, 30.0, _VEHICLES)
    speed[0] = 0.0
    y, rate, wanted = rng.normal(0.0, 1.0, (3, _STEPS, _VEHICLES))
    return [LateralMotion(_ROWS, STEP_S, y[k], 0.3 * rate[k], wanted[k], speed) for k in range(_STEPS)]


def situations() -> list[Situation]:
    """Return what reactions are given: 12 s of seven vehicles, all but the first of which are in alarm for a while."""
    rng = np.random.default_rng(2)
    key = rng.integers(1, 2**63, _VEHICLES).astype(np.uint64)
    begin, lasts = rng.integers(5, 40, _VEHICLES), rng.integers(3, 70, _VEHICLES)
    lasts[0] = 0
    speed = rng.uniform(0.0, 30.0, _VEHICLES)
    return [Situation(_ROWS, key, k, STEP_S, (k >= begin) & (k < begin + lasts), speed) for k in range(_STEPS)]


@dataclass(frozen=True)
class SteeringCase:
    """Dynamics or a reaction to be checked.

    Attributes:
        kind: its class.
        parameters: with which it shows all it does within ten seconds.
    """

    kind: type[LateralDynamics] | type[Reaction]
    parameters: dict[str, object] = field(default_factory=dict)

    @property
    def moves(self) -> bool:
        """Whether it is lateral dynamics."""
        return issubclass(self.kind, LateralDynamics)

    def given(self) -> Sequence[Any]:
        """Return what a part of its kind is given, step by step."""
        return motions() if self.moves else situations()

    def answers(self, given: Sequence[Any], state: Any = None) -> list[TwoArrays]:
        """Return both arrays of the answer to each step."""
        part = self.kind(**self.parameters)
        rows = part.new_state(64).now if state is None else state
        answers: list[Any] = [part.apply(one, rows) for one in given]
        return [tuple(vars(answer).values()) for answer in answers]


def check_dynamics(kind: type[LateralDynamics], **parameters: object) -> None:
    """Hold lateral dynamics to their contract; `parameters` are those with which they show all they do within 10 s.

    Raises:
        BrokenContractError: they break a rule, which is said.
    """
    for check in STEERING_CHECKS:
        check(SteeringCase(kind, dict(parameters)))


def check_reaction(kind: type[Reaction], **parameters: object) -> None:
    """Hold a reaction to its contract; `parameters` are those with which it shows all it does within ten seconds.

    Raises:
        BrokenContractError: it breaks a rule, which is said.
    """
    for check in STEERING_CHECKS:
        check(SteeringCase(kind, dict(parameters)))


def its_parameters_are_bounded_and_documented(case: SteeringCase) -> None:
    """Hold the fields: a user has to be told what they are, and within which bounds."""
    require(isinstance(getattr(case.kind, "name", None), str) and case.kind.name, "it has a `name`")
    documented = "".join(base.__doc__ or "" for base in case.kind.__mro__)
    for name, parameter in case.kind.model_fields.items():
        bounded = parameter.annotation is not float or len(parameter.metadata) >= 2
        require(bounded, f"{name}: a number has a lower and an upper bound")
        require(name in documented, f"{name}: a parameter has a line in the docstring")
        require(not parameter.is_required(), f"{name}: a parameter has a default")


def its_answers_are_finite_and_mean_something(case: SteeringCase) -> None:
    """Hold shapes and types, which `apply` looks at, and the values."""
    try:
        answers = case.answers(case.given())
        case.answers([_taken(case.given()[0], _ROWS[:0])])
    except TypeError as error:
        require(False, str(error))
    for first, second in answers:
        require(np.isfinite(first).all() and np.isfinite(second).all(), "answers are finite")
        if not case.moves:
            require(np.isin(first, list(Follow)).all(), "`follow` is one of `Follow`")
            require((second >= 0.0).all(), "`brake_mps2` is not negative")


def it_does_what_it_is_there_for(case: SteeringCase) -> None:
    """Hold that dynamics get where they are wanted and no vehicle moves that stands; that no reaction is unprovoked."""
    if not case.moves:
        require(
            all(follow[0] == Follow.ESTIMATE and brake[0] == 0.0 for follow, brake in case.answers(case.given())),
            "a vehicle without an alarm drives on by its estimate",
        )
        return
    part = case.kind(**case.parameters)
    require(isinstance(part, LateralDynamics), "dynamics are LateralDynamics")
    state, still = part.new_state(2).now, np.zeros(2)
    one = LateralMotion(_ROWS[:2], STEP_S, still, still, np.ones(2), np.array([10.0, 0.0]))
    for _ in range(300):
        moved: Any = part.apply(one, state)  # type: ignore[arg-type]
        one = replace(one, offset_m=moved.offset_m, rate_mps=moved.rate_mps)
    require(abs(one.offset_m[0] - 1.0) < 0.01, "at 10 m/s a vehicle is within 30 s where it wants to be")
    require(one.offset_m[1] == 0.0, "a vehicle that stands does not move across the road")


def the_same_steps_give_the_same_bytes(case: SteeringCase) -> None:
    """Hold determinism."""
    same = same_answers(case.answers(case.given()), case.answers(case.given()))
    require(same, "the same input gives the same bytes; draw from gpsec.core.noise")


def what_it_is_given_is_left_alone(case: SteeringCase) -> None:
    """Hold that it does not write into what it is given."""
    given = case.given()
    case.answers(given)
    for one, fresh in zip(given, case.given(), strict=True):
        for part in fields(one):
            same = np.array_equal(getattr(one, part.name), getattr(fresh, part.name))
            require(same, f"`{part.name}` is left alone; answer with new arrays")


def company_and_order_do_not_matter(case: SteeringCase) -> None:
    """Hold that a vehicle's answer does not depend on who else is there, nor on its place, to the last bit."""
    batch = case.answers(case.given())
    order = np.array([4, 2, 6, 0, 1, 5, 3], np.int32)
    for chosen in (*([k] for k in _ROWS), order):
        picked = np.array(chosen, np.int32)
        alone = case.answers([_taken(one, picked) for one in case.given()])
        same = same_answers([(a[picked], b[picked]) for a, b in batch], alone)
        require(same, "a row is the same in whatever company and order; numpy's sines and powers are not")


def state_is_kept_at_its_rows(case: SteeringCase) -> None:
    """Hold that the state is read and written at `rows`, and that a row that is reset begins anew."""
    rows = np.array([12, 3, 7, 40, 0, 9, 5], np.int32)
    table = case.kind(**case.parameters).new_state(64)
    moved = [replace(one, rows=rows) for one in case.given()]
    expected = case.answers(case.given())
    require(same_answers(expected, case.answers(moved, table.now)), "state is kept at `rows`, whichever they are")
    table.reset(rows)
    require(same_answers(expected, case.answers(moved, table.now)), "a row that is reset begins anew")


def _taken(one: Any, chosen: Ints) -> Any:
    """Return some of the vehicles of a step."""
    arrays = {part.name: getattr(one, part.name) for part in fields(one)}
    return replace(one, **{name: value[chosen] for name, value in arrays.items() if isinstance(value, np.ndarray)})


def same_answers(one: Sequence[TwoArrays], other: Sequence[TwoArrays]) -> bool:
    """Return whether two runs of answers are equal to the last bit."""
    pairs = zip(one, other, strict=True)
    return all(np.array_equal(a, c) and np.array_equal(b, d) for (a, b), (c, d) in pairs)


STEERING_CHECKS: tuple[Callable[[SteeringCase], None], ...] = (
    its_parameters_are_bounded_and_documented,
    its_answers_are_finite_and_mean_something,
    it_does_what_it_is_there_for,
    the_same_steps_give_the_same_bytes,
    what_it_is_given_is_left_alone,
    company_and_order_do_not_matter,
    state_is_kept_at_its_rows,
)
