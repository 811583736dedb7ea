"""The contract of an attack: `check_attack` holds all of it, each function of `ATTACK_CHECKS` one rule."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gpsec.attacks.base import Attack, Spoofed
from gpsec.attacks.plans import PlanConfig
from gpsec.core.arrays import Flags, Floats
from gpsec.testing.contract import require
from gpsec.testing.victims import Surroundings, drive, make_victims

# What may stand beside an attack's own parameters: in a plan, and at a zone or a vehicle.
RESERVED = frozenset(PlanConfig.model_fields) | {"begin", "end", "radius_m", "hold_s", "plan", "equipped", "sensors"}
SpoofedSteps = list[tuple[Any, Spoofed]]


@dataclass(frozen=True)
class AttackCase:
    """An attack to be checked.

    Attributes:
        kind: its class.
        parameters: with which it shows all it does within two seconds.
        denies_fixes: it takes fixes away that the vehicle would have had.
        world: what its victims see.
    """

    kind: type[Attack]
    parameters: dict[str, object] = field(default_factory=dict)
    denies_fixes: bool = False
    world: Surroundings = field(default_factory=Surroundings.random)

    def build(self) -> Attack:
        """Return the attack with its parameters."""
        return self.kind(**self.parameters)

    def answers(self, world: Surroundings | None = None, rows: Any = None) -> SpoofedSteps:
        """Return (victims, their fixes) of every step."""
        return drive(self.build(), self.world if world is None else world, rows)


def check_attack(kind: type[Attack], *, denies_fixes: bool = False, **parameters: object) -> None:
    """Hold an attack to its contract.

    Args:
        kind: its class.
        denies_fixes: it takes fixes away that the vehicle would have had.
        parameters: with which it shows all it does within two seconds; the others keep their defaults.

    Raises:
        BrokenContractError: it breaks a rule, which is said.
    """
    case = AttackCase(kind, dict(parameters), denies_fixes)
    for check in ATTACK_CHECKS:
        check(case)


def parameters_are_bounded_documented_and_free_of_reserved_names(case: AttackCase) -> None:
    """Hold the fields: a user has to be told what they are, and a typing error must not become an attack."""
    require(isinstance(getattr(case.kind, "name", None), str) and case.kind.name, "an attack has a `name`")
    documented = "".join(base.__doc__ or "" for base in case.kind.__mro__)
    for name, parameter in case.kind.model_fields.items():
        bounded = parameter.annotation is not float or len(parameter.metadata) >= 2
        require(bounded, f"{name}: a number has a lower and an upper bound")
        require(name in documented, f"{name}: a parameter has a line in the docstring")
        require(not parameter.is_required(), f"{name}: a parameter has a default")
        require(name not in RESERVED, f"{name}: this name is taken by a key that may stand beside it")


def answers_have_shapes_types_and_finite_values(case: AttackCase) -> None:
    """Hold the shapes, the types, and that nothing is NaN or infinite."""
    for on, spoofed in case.answers():
        require(spoofed.fix_m.shape == (len(on), 2), "`fix_m` is (m, 2)")
        require(spoofed.fix_m.dtype == np.float64, "`fix_m` is of float64")
        require(spoofed.valid.shape == (len(on),), "`valid` is (m,)")
        require(spoofed.valid.dtype == np.bool_, "`valid` is of bool")
        require(np.isfinite(spoofed.fix_m).all(), "`fix_m` is finite, also where there is no fix")


def nobody_is_a_victim(case: AttackCase) -> None:
    """Hold that a step without victims is answered."""

    def nothing(delay_s: float) -> tuple[Floats, Flags]:
        return np.zeros((0, 2)), np.zeros(0, np.bool_)

    attack = case.build()
    spoofed = attack.apply(make_victims(0, past_fix=nothing), attack.new_state(4).now)
    require(spoofed.fix_m.shape == (0, 2), "a step without victims has an answer of no rows")


def a_fix_is_never_made_where_there_was_none(case: AttackCase) -> None:
    """Hold the mask, and that fixes are taken away just where the attack says so."""
    kept = True
    for step, (on, spoofed) in enumerate(case.answers()):
        honest = case.world.fix_valid[step, on]
        require(not np.any(spoofed.valid & ~honest), "there is no spoofed fix where there is no honest one")
        kept &= np.array_equal(spoofed.valid, honest)
    require(kept or case.denies_fixes, "an attack keeps every fix; where it takes some away, say `denies_fixes`")
    require(not (kept and case.denies_fixes), "an attack with `denies_fixes` takes fixes away")


def it_does_something(case: AttackCase) -> None:
    """Hold that nearly every fix of an attack that has begun is elsewhere, or gone."""
    far, seen = 0, 0
    for step, (on, spoofed) in enumerate(case.answers()):
        # What grows is still zero in its first step, and what swings is zero now and then.
        begun = (case.world.began[on] < step) & case.world.fix_valid[step, on]
        moved = np.linalg.norm(spoofed.fix_m - case.world.fix_m[step, on], axis=1) > 0.01
        far += int(np.sum((moved | ~spoofed.valid)[begun]))
        seen += int(np.sum(begun))
    require(far > 0.9 * seen, "fixes under attack are moved by more than a centimetre, or taken away, in most steps")


def the_same_input_gives_the_same_bytes(case: AttackCase) -> None:
    """Hold determinism."""
    require(
        same_fixes(case.answers(), case.answers()), "the same input gives the same bytes; draw from gpsec.core.noise"
    )


def inputs_are_left_alone(case: AttackCase) -> None:
    """Hold that neither `spoof` nor one who writes into its answer changes what the victims hold."""
    past_m, exists = np.ones((3, 2)), np.array([True, False, True])
    victims = make_victims(3, elapsed_s=np.full(3, 2.0), past_fix=lambda delay_s: (past_m, exists))
    held = {name: value for name, value in vars(victims).items() if isinstance(value, np.ndarray)}
    held |= {"past_m": past_m, "exists": exists}
    before = {name: value.copy() for name, value in held.items()}
    attack = case.build()
    spoofed = attack.apply(victims, attack.new_state(3).now)
    spoofed.fix_m[:] = -1.0
    spoofed.valid[:] = ~spoofed.valid
    for name, value in held.items():
        require(np.array_equal(before[name], value), f"`{name}` of the victims is left alone; answer with new arrays")


def the_batch_equals_a_loop_of_singles(case: AttackCase) -> None:
    """Hold that a victim's fix does not depend on its company, to the last bit."""
    batch = case.answers()
    for i in range(len(case.world.key)):
        alone = case.answers(case.world.take(np.array([i])))
        for (on, together), (_, single) in zip(batch, alone, strict=True):
            at = on == i
            equal = np.array_equal(together.fix_m[at], single.fix_m) and np.array_equal(
                together.valid[at], single.valid
            )
            require(equal, "a row is the same in whatever company it is computed; numpy's sines and powers are not")


def the_order_of_victims_does_not_matter(case: AttackCase) -> None:
    """Hold that a row has its own state and noise, wherever it stands."""
    order = np.random.default_rng(1).permutation(len(case.world.key))
    for (on, a), (on_b, b) in zip(case.answers(), case.answers(case.world.take(order)), strict=True):
        back = np.argsort(order[on_b])
        equal = np.array_equal(a.fix_m, b.fix_m[back]) and np.array_equal(a.valid, b.valid[back])
        require(np.array_equal(order[on_b][back], on) and equal, "the order of the victims does not matter")


def track_rows_do_not_matter(case: AttackCase) -> None:
    """Hold that the state is read and written at `victims.rows`, and at no other places."""
    rows = np.array([12, 3, 7, 40, 0, 9, 5], np.int32)
    require(same_fixes(case.answers(), case.answers(rows=rows)), "state is kept at `victims.rows`, whichever they are")


def it_never_looks_at_later_data(case: AttackCase) -> None:
    """Hold causality."""
    changed = case.answers(case.world.change_from(45))
    require(same_fixes(case.answers()[:45], changed[:45]), "no fix depends on what comes later")


def it_looks_back_no_further_than_it_says(case: AttackCase) -> None:
    """Hold `needed_memory_s`."""
    attack = case.build()
    delays: list[float] = []
    drive(attack, case.world, watch=delays.append)
    longest = attack.needed_memory_s()
    require(all(0.0 <= delay <= longest for delay in delays), "`past_fix` is asked for no more than `needed_memory_s`")
    require(bool(delays) == (longest > 0.0), "`needed_memory_s` is above 0 just where `past_fix` is used")


def a_reset_row_begins_anew(case: AttackCase) -> None:
    """Hold that a row which was used for another track and reset behaves as a fresh one."""
    attack = case.build()
    fresh = make_victims(
        1,
        step=100,
        deviation_m=np.array([0.1]),
        right_lane=np.array([True]),
        past_fix=lambda delay_s: (np.ones((1, 2)), np.ones(1, np.bool_)),
    )
    used = make_victims(
        1,
        step=50,
        deviation_m=np.array([9.0]),
        elapsed_s=np.array([5.0]),
        left_lane=np.array([True]),
        past_fix=fresh.past_fix,
    )
    expected = attack.apply(fresh, attack.new_state(1).now).fix_m
    state = attack.new_state(1)
    attack.apply(used, state.now)
    state.reset(used.rows)
    require(np.array_equal(attack.apply(fresh, state.now).fix_m, expected), "a row that is reset begins anew")


def same_fixes(one: SpoofedSteps, other: SpoofedSteps) -> bool:
    """Return whether two answers are equal to the last bit."""
    return all(
        np.array_equal(a.fix_m, b.fix_m) and np.array_equal(a.valid, b.valid)
        for (_, a), (_, b) in zip(one, other, strict=True)
    )


ATTACK_CHECKS: tuple[Callable[[AttackCase], None], ...] = (
    parameters_are_bounded_documented_and_free_of_reserved_names,
    answers_have_shapes_types_and_finite_values,
    nobody_is_a_victim,
    a_fix_is_never_made_where_there_was_none,
    it_does_something,
    the_same_input_gives_the_same_bytes,
    inputs_are_left_alone,
    the_batch_equals_a_loop_of_singles,
    the_order_of_victims_does_not_matter,
    track_rows_do_not_matter,
    it_never_looks_at_later_data,
    it_looks_back_no_further_than_it_says,
    a_reset_row_begins_anew,
)
