"""What every registered attack must keep; a new attack needs a row in the table."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from gpsec.arrays import Flags
from gpsec.attacks.base import Attack
from gpsec.attacks.plans import PlanConfig
from gpsec.attacks.registry import ATTACKS, build_attack

from .helpers import World, displacement, drive, make_victims


@dataclass(frozen=True)
class Case:
    """An attack with parameters that make it show all it does within the 6 s of `World.random`."""

    name: str
    parameters: dict[str, object] = field(default_factory=dict)
    denies_fixes: bool = False
    """It takes fixes away that the vehicle would have had."""
    has_state: bool = False

    def build(self) -> Attack:
        return build_attack(self.name, self.parameters, "test")


CASES = [
    Case("constant_bias"),
    Case("constant_bias", {"frame": "world", "side": "as_given"}),
    Case("stealth", {"gamma_m": 0.5, "cap_m": 2.0}),
    Case("two_stage", {"timeout_s": 1.0, "update_s": 0.3}, has_state=True),
    Case("drift", {"cap_m": 0.5}),
    Case("noise"),
    Case("replay", {"delay_s": 1.5}, denies_fixes=True),
    Case("jamming", denies_fixes=True),
    Case("lane_alias", has_state=True),
    Case("lane_alias", {"side": "right"}, has_state=True),
]
every_attack = pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.name}{case.parameters or ''}")


@pytest.fixture(scope="module")
def world() -> World:
    return World.random()


def same(one: list, other: list, steps: slice = slice(None)) -> bool:
    """Equal to the last bit."""
    return all(
        np.array_equal(a.fix_m, b.fix_m) and np.array_equal(a.valid, b.valid)
        for (_, a), (_, b) in zip(one[steps], other[steps], strict=True)
    )


def test_the_table_has_every_attack() -> None:
    assert {case.name for case in CASES} == set(ATTACKS)


def test_names_agree_with_the_registry() -> None:
    assert all(attack.name == name for name, attack in ATTACKS.items())


def test_parameters_never_share_a_name_with_a_key_that_may_stand_beside_them() -> None:
    beside = set(PlanConfig.model_fields) | {"begin", "end", "radius_m", "equipped", "sensors"}
    for attack in ATTACKS.values():
        assert not beside & set(attack.model_fields)


@every_attack
def test_parameters_have_bounds_or_choices(case: Case) -> None:
    for name, parameter in ATTACKS[case.name].model_fields.items():
        bounded = len(parameter.metadata) >= 2 if parameter.annotation is float else True
        assert bounded, name
        assert f"{name}" in "".join(base.__doc__ or "" for base in ATTACKS[case.name].__mro__), name


@every_attack
def test_shapes_types_and_finite_values(case: Case, world: World) -> None:
    for on, spoofed in drive(case.build(), world):
        assert spoofed.fix_m.shape == (len(on), 2)
        assert spoofed.fix_m.dtype == np.float64
        assert spoofed.valid.shape == (len(on),)
        assert spoofed.valid.dtype == np.bool_
        assert np.isfinite(spoofed.fix_m).all()


@every_attack
def test_nobody_is_a_victim(case: Case) -> None:
    def none_there(delay_s: float) -> tuple[np.ndarray, Flags]:
        return np.zeros((0, 2)), np.zeros(0, np.bool_)

    attack = case.build()
    spoofed = attack.apply(make_victims(0, past_fix=none_there), attack.new_state(4))
    assert spoofed.fix_m.shape == (0, 2)


@every_attack
def test_a_fix_is_never_made_where_there_was_none(case: Case, world: World) -> None:
    kept = True
    for step, (on, spoofed) in enumerate(drive(case.build(), world)):
        honest = world.fix_valid[step, on]
        assert not np.any(spoofed.valid & ~honest)
        kept &= np.array_equal(spoofed.valid, honest)
    assert kept != case.denies_fixes


@every_attack
def test_it_does_something(case: Case, world: World) -> None:
    for step, (on, spoofed) in enumerate(drive(case.build(), world)):
        begun = (world.began[on] < step) & world.fix_valid[step, on]  # a drift is still zero in its first step
        far = np.linalg.norm(spoofed.fix_m - world.fix_m[step, on], axis=1) > 0.01
        assert np.all(far[begun] | ~spoofed.valid[begun])


@every_attack
def test_same_input_same_bytes(case: Case, world: World) -> None:
    assert same(drive(case.build(), world), drive(case.build(), world))


@every_attack
def test_inputs_are_left_alone(case: Case) -> None:
    """Neither `spoof` nor one who writes into its answer changes what the victims hold."""
    past_m, exists = np.ones((3, 2)), np.array([True, False, True])
    victims = make_victims(3, elapsed_s=np.full(3, 2.0), past_fix=lambda delay_s: (past_m, exists))
    held = {name: value for name, value in vars(victims).items() if isinstance(value, np.ndarray)}
    held |= {"past_m": past_m, "exists": exists}
    before = {name: value.copy() for name, value in held.items()}
    attack = case.build()
    spoofed = attack.apply(victims, attack.new_state(3))
    spoofed.fix_m[:] = -1.0
    spoofed.valid[:] = ~spoofed.valid
    for name, value in held.items():
        assert np.array_equal(before[name], value), name


@every_attack
def test_the_batch_equals_a_loop_of_singles(case: Case, world: World) -> None:
    batch = drive(case.build(), world)
    for i in range(len(world.key)):
        alone = drive(case.build(), world.take(np.array([i])))
        for (on, together), (_, single) in zip(batch, alone, strict=True):
            at = on == i
            assert np.array_equal(together.fix_m[at], single.fix_m)
            assert np.array_equal(together.valid[at], single.valid)


@every_attack
def test_the_order_of_victims_does_not_matter(case: Case, world: World) -> None:
    order = np.array([3, 0, 6, 1, 5, 2, 4])
    batch, shuffled = drive(case.build(), world), drive(case.build(), world.take(order))
    for (on, a), (on_b, b) in zip(batch, shuffled, strict=True):
        back = np.argsort(order[on_b])
        assert np.array_equal(order[on_b][back], on)
        assert np.array_equal(a.fix_m, b.fix_m[back])
        assert np.array_equal(a.valid, b.valid[back])


@every_attack
def test_track_rows_do_not_matter(case: Case, world: World) -> None:
    rows = np.array([12, 3, 7, 40, 0, 9, 5], np.int32)
    assert same(drive(case.build(), world), drive(case.build(), world, rows))


@every_attack
def test_it_never_looks_at_later_data(case: Case, world: World) -> None:
    now, changed = drive(case.build(), world), drive(case.build(), world.change_from(45))
    assert same(now, changed, slice(45))
    assert same(now, changed) == (case.name == "jamming")


@every_attack
def test_it_looks_back_no_further_than_it_says(case: Case, world: World) -> None:
    attack = case.build()
    delays: list[float] = []
    drive(attack, world, watch=delays.append)
    assert all(0.0 <= delay <= attack.needed_memory_s() for delay in delays)
    assert bool(delays) == (attack.needed_memory_s() > 0.0)


@every_attack
def test_a_reset_row_begins_anew(case: Case) -> None:
    """A row that was used for another track and reset behaves as a fresh one; without the reset it does not."""
    attack = case.build()
    fresh = make_victims(
        1,
        step=100,
        deviation_m=np.array([0.1]),
        right_lane=np.array([True]),
        past_fix=lambda s: (np.ones((1, 2)), np.ones(1, np.bool_)),
    )
    used = make_victims(
        1,
        step=50,
        deviation_m=np.array([9.0]),
        elapsed_s=np.array([5.0]),
        left_lane=np.array([True]),
        past_fix=fresh.past_fix,
    )
    expected = displacement(attack, fresh)
    state = attack.new_state(1)
    attack.apply(used, state)
    state.reset(used.rows)
    assert np.array_equal(attack.apply(fresh, state).fix_m - fresh.fix_m, expected)
    assert type(state).__name__.startswith("NoState") != case.has_state
