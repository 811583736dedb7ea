"""Each attack's fixes against values worked out by hand. Lanes lead east unless said otherwise: left is north."""

import math

import numpy as np
import pytest

from gpsec.attacks.adaptive import Adaptive
from gpsec.attacks.base import Attack, NoState, Spoofed, Victims, powers, unit_vectors
from gpsec.attacks.blind_drift import BlindDrift
from gpsec.attacks.constant_bias import ConstantBias
from gpsec.attacks.drift import Drift
from gpsec.attacks.jamming import Jamming
from gpsec.attacks.lane_alias import LaneAlias
from gpsec.attacks.noise import Noise
from gpsec.attacks.probing import Probed
from gpsec.attacks.replay import Replay
from gpsec.attacks.stealth import Stealth
from gpsec.attacks.two_stage import TwoStage
from gpsec.testing.victims import displacement, make_victims

NORTH = np.pi / 2


def near(expected: object) -> object:
    return pytest.approx(np.asarray(expected), abs=1e-12)


def test_unit_vectors_and_powers() -> None:
    assert unit_vectors(np.array([0.0, NORTH, np.pi])) == near([[1, 0], [0, 1], [-1, 0]])
    assert powers(2.0, np.array([0.0, 3.0, -1.0, 0.5])) == near([1.0, 8.0, 0.5, math.sqrt(2.0)])


def test_constant_bias_turns_with_the_lane() -> None:
    attack = ConstantBias(bias_m=2.0, side="as_given")
    assert displacement(attack, make_victims(2, lane_yaw_rad=np.array([0.0, NORTH]))) == near([[0, 2], [-2, 0]])


def test_constant_bias_in_the_world_frame_does_not_turn() -> None:
    attack = ConstantBias(bias_m=5.0, side="as_given", frame="world", direction_deg=math.degrees(math.atan2(4, 3)))
    assert displacement(attack, make_victims(2, lane_yaw_rad=np.array([0.0, NORTH]))) == near([[3, 4], [3, 4]])


def test_a_random_side_is_the_vehicles_own_and_even() -> None:
    attack = ConstantBias(bias_m=2.0)
    moved = displacement(attack, make_victims(2000))[:, 1]
    assert np.abs(moved) == near(np.full(2000, 2.0))
    assert 0.45 < np.mean(moved > 0) < 0.55  # 4.5 standard deviations of a fair coin
    assert np.array_equal(moved > 0, displacement(Drift(), make_victims(2000, elapsed_s=np.ones(2000)))[:, 1] > 0)


@pytest.mark.parametrize(
    ("elapsed_s", "expected_m"),
    [(0.0, 0.1), (0.1, 0.11), (0.2, 0.121), (0.5, 0.161051), (2.5, 1.0), (1e6, 1.0)],
)
def test_stealth_grows_tenth_by_tenth_to_its_cap(elapsed_s: float, expected_m: float) -> None:
    """0.1 * 1.1^k; 1.1^25 = 10.83 is over the cap, and 1.1^(10^7) is no float."""
    attack = Stealth(gamma_m=0.1, delta=1.1, cap_m=1.0, side="as_given")
    for step_s in (0.05, 0.1):  # the step does not matter
        victims = make_victims(1, elapsed_s=np.array([elapsed_s]), step_s=step_s)
        assert displacement(attack, victims) == near([[0.0, expected_m]])


def test_stealth_with_a_cap_below_its_start_is_constant() -> None:
    attack = Stealth(gamma_m=1.0, cap_m=0.25, side="as_given")
    assert displacement(attack, make_victims(2, elapsed_s=np.array([0.0, 7.0]))) == near([[0, 0.25], [0, 0.25]])


def test_stealth_defaults_are_what_the_docstring_says() -> None:
    moved = displacement(Stealth(side="as_given"), make_victims(3, elapsed_s=np.array([0.0, 5.0, 10.0])))[:, 1]
    assert moved == pytest.approx([0.02, 0.23, 2.63], abs=0.005)  # 1.05^50 = 11.467, 1.05^100 = 131.50


def test_blind_drift_grows_only_where_the_camera_is_blind_to_its_cap() -> None:
    attack = BlindDrift(rate_mps=1.0, cap_m=0.25, side="as_given")
    state, moved = attack.new_state(2).now, []
    for first in (True, False, True, True):
        victims = make_victims(2, blind=np.array([first, False]))
        moved.append(attack.apply(victims, state).fix_m[:, 1].tolist())
    assert np.array(moved) == near([[0.1, 0], [0.1, 0], [0.2, 0], [0.25, 0]])


def test_drift_is_linear_to_its_cap() -> None:
    attack = Drift(rate_mps=0.2, cap_m=1.5, side="as_given")
    victims = make_victims(4, elapsed_s=np.array([0.0, 0.5, 7.0, 100.0]))
    assert displacement(attack, victims)[:, 1] == near([0.0, 0.1, 1.4, 1.5])


def test_noise_has_its_standard_deviation_on_both_axes_and_from_step_to_step() -> None:
    n = 4000
    first, second = (displacement(Noise(sigma_m=3.0), make_victims(n, step=step)) for step in (1, 2))
    assert first.std(axis=0) == pytest.approx([3.0, 3.0], rel=0.05)  # 4.5 standard errors of 3/sqrt(2n)
    assert first.mean(axis=0) == pytest.approx([0.0, 0.0], abs=0.22)  # 4.5 standard errors of 3/sqrt(n)
    assert abs(np.corrcoef(first[:, 0], first[:, 1])[0, 1]) < 0.07
    assert abs(np.corrcoef(first[:, 0], second[:, 0])[0, 1]) < 0.07


def test_replay_gives_the_past_fix_where_there_is_one() -> None:
    asked: list[float] = []

    def past_fix(delay_s: float) -> tuple[np.ndarray, np.ndarray]:
        asked.append(delay_s)
        return np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]), np.array([True, False, True])

    victims = make_victims(3, past_fix=past_fix, fix_valid=np.array([True, True, False]))
    attack = Replay(delay_s=4.0)
    spoofed = attack.apply(victims, attack.new_state(3).now)
    assert asked == [4.0]
    assert spoofed.valid.tolist() == [True, False, False]
    assert spoofed.fix_m[0].tolist() == [1.0, 2.0]
    assert attack.needed_memory_s() == 4.0


def test_jamming_leaves_no_fix_and_no_honest_position_under_the_mask() -> None:
    attack = Jamming()
    spoofed = attack.apply(make_victims(2, fix_m=np.array([[7.0, 8.0], [9.0, 1.0]])), attack.new_state(2).now)
    assert not spoofed.valid.any()
    assert not spoofed.fix_m.any()


@pytest.mark.parametrize(
    ("side", "left", "right", "expected_m"),
    [
        ("adjacent", True, False, 3.5),
        ("adjacent", False, True, -3.5),
        ("left", False, True, 3.5),
        ("right", True, False, -3.5),
    ],
)
def test_lane_alias_goes_where_a_lane_is(side: str, left: bool, right: bool, expected_m: float) -> None:
    victims = make_victims(1, lane_width_m=np.array([3.5]), left_lane=np.array([left]), right_lane=np.array([right]))
    assert displacement(LaneAlias(side=side), victims) == near([[0.0, expected_m]])


@pytest.mark.parametrize("there", [True, False])
def test_lane_alias_draws_where_both_or_neither_side_has_a_lane(there: bool) -> None:
    both = np.full(2000, there)
    moved = displacement(LaneAlias(), make_victims(2000, left_lane=both, right_lane=both))[:, 1]
    assert np.abs(moved) == near(np.full(2000, 3.2))
    assert 0.45 < np.mean(moved > 0) < 0.55


def test_lane_alias_keeps_its_side_after_a_lane_change_and_follows_the_width() -> None:
    attack = LaneAlias()
    state = attack.new_state(1).now
    yes, no = np.array([True]), np.array([False])
    attack.apply(make_victims(1, left_lane=yes, right_lane=no), state)
    later = attack.apply(make_victims(1, left_lane=no, right_lane=yes, lane_width_m=np.array([2.8])), state)
    assert later.fix_m == near([[0.0, 2.8]])


def run_two_stage(attack: TwoStage, deviation_m: list[float], step_s: float = 0.1) -> list[float]:
    """Displacement to the left in each step of one victim."""
    state = attack.new_state(1).now
    return [
        float(
            attack.apply(
                make_victims(
                    1, step=50 + i, step_s=step_s, elapsed_s=np.array([i * step_s]), deviation_m=np.array([deviation])
                ),
                state,
            ).fix_m[0, 1]
        )
        for i, deviation in enumerate(deviation_m)
    ]


def test_two_stage_waits_for_the_victim_and_then_grows() -> None:
    attack = TwoStage(d_m=0.5, f=2.0, trigger_m=0.3, update_s=0.2, cap_m=3.0, side="left")
    moved = run_two_stage(attack, [0.0, 0.29, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert moved == near([0.5, 0.5, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0])


def test_two_stage_counts_deviation_to_its_own_side_only() -> None:
    deviation = [0.0, 0.5, -0.5, 0.0]
    left, right = (TwoStage(d_m=0.4, f=1.5, update_s=1.0, side=side) for side in ("left", "right"))
    assert run_two_stage(left, deviation) == near([0.4, 0.6, 0.6, 0.6])
    assert run_two_stage(right, deviation) == near([-0.4, -0.4, -0.6, -0.6])


def test_two_stage_stops_waiting() -> None:
    attack = TwoStage(d_m=0.5, f=2.0, timeout_s=1.0, update_s=1.0, side="left")
    assert run_two_stage(attack, [0.0] * 5, step_s=0.5) == near([0.5, 0.5, 1.0, 1.0, 2.0])


def test_two_stage_does_not_overflow() -> None:
    attack = TwoStage(f=2.0, timeout_s=0.0, update_s=0.1, cap_m=10.0, side="left")
    state = attack.new_state(1).now
    attack.apply(make_victims(1, step=0), state)
    late = attack.apply(make_victims(1, step=10_000, elapsed_s=np.array([1000.0])), state)
    assert late.fix_m == near([[0.0, 10.0]])


def test_a_wrong_shape_is_named() -> None:
    class Flat(Attack):
        name = "flat"

        def spoof(self, victims: Victims, state: NoState) -> Spoofed:
            return Spoofed(victims.fix_m[:, 0], victims.fix_valid)

    with pytest.raises(TypeError, match=r"'flat': fix_m must be \(3, 2\) of float64, found \(3,\)"):
        Flat().apply(make_victims(3), Flat().new_state(3).now)


def at_distance(limit_m: float, *, scored: bool = True):
    """Return a probe of a detector whose statistic is the distance from the honest fix, and one that scores nothing."""

    def probe(moved_m: np.ndarray) -> Probed:
        ratio = np.linalg.norm(moved_m, axis=2) / limit_m
        return Probed(ratio if scored else 0.0 * ratio, np.full(ratio.shape, scored))

    return probe


def adaptive_way(attack: Adaptive, victims: list[Victims]) -> list[float]:
    """Return displacements to the left, step by step."""
    state = attack.new_state(1).now
    return [float(attack.apply(one, state).fix_m[0, 1] - one.fix_m[0, 1]) for one in victims]


def test_adaptive_grows_to_the_level_and_no_further() -> None:
    attack = Adaptive(level=0.5, growth_m=0.2, side="as_given")
    victims = [make_victims(1, probe=at_distance(1.0))] * 5
    # The level is 0.5 m. From 0.4 m on a sixteenth of 0.2 m is tried: 0.1 m further is one of them.
    assert adaptive_way(attack, victims) == near([0.2, 0.4, 0.5, 0.5, 0.5])


def test_adaptive_gives_way_when_the_detector_would_notice() -> None:
    attack = Adaptive(level=1.0, growth_m=0.24, side="as_given")
    victims = [make_victims(1, probe=at_distance(limit_m)) for limit_m in (9.0, 9.0, 0.1, 0.1)]
    # Back by twenty-fourths of 0.48 m, to 5/24, and then on by sixteenths of 0.24 m: none fits under 0.1 m.
    assert adaptive_way(attack, victims) == near([0.24, 0.48, 0.1, 0.1])


def test_adaptive_takes_what_is_least_suspicious_where_all_is_an_alarm() -> None:
    def offended(moved_m: np.ndarray) -> Probed:
        return Probed(5.0 + np.abs(moved_m[:, :, 1] + 0.2), np.ones(moved_m.shape[:2], np.bool_))

    attack = Adaptive(growth_m=0.05, side="as_given")
    assert adaptive_way(attack, [make_victims(1, probe=offended)]) == near([-0.2])


@pytest.mark.parametrize(
    ("junctions", "expected"), [("hold", [0.05, 0.05, 0.05, 0.05]), ("move", [0.05, 0.55, 1.05, 0.05])]
)
def test_adaptive_moves_in_junctions_only_if_it_is_told_to(junctions: str, expected: list[float]) -> None:
    """Behind them, before anything is scored, it is where it was before."""
    attack = Adaptive(growth_m=0.05, junction_growth_m=0.5, junctions=junctions, side="as_given")  # type: ignore[arg-type]
    unseen = at_distance(1.0, scored=False)
    inside = make_victims(1, probe=unseen, blind=np.array([True]))
    victims = [make_victims(1, probe=at_distance(9.0)), inside, inside, make_victims(1, probe=unseen)]
    assert adaptive_way(attack, victims) == near(expected)


def test_adaptive_moves_in_junctions_as_far_as_fixes_are_tested_there() -> None:
    attack = Adaptive(level=1.0, junction_growth_m=0.5, junctions="move", side="as_given")
    inside = make_victims(1, probe=at_distance(0.75), blind=np.array([True]))
    assert adaptive_way(attack, [inside] * 3) == near([0.5, 0.75, 0.75])


def test_adaptive_keeps_to_its_cap_and_waits_for_fixes() -> None:
    attack = Adaptive(growth_m=2.0, cap_m=3.0, side="as_given")
    there, missing = make_victims(1, probe=at_distance(99.0)), make_victims(1, fix_valid=np.array([False]))
    assert adaptive_way(attack, [there, missing, there]) == near([2.0, 2.0, 3.0])


def test_adaptive_by_queries_halves_its_strides_until_its_answers_are_used_up() -> None:
    """0.4, 0.8 pass; 1.2 does not, so back to 0.4; 0.6, 0.8 pass; 1.0 does not; then it has asked six times."""
    attack = Adaptive(knowledge="queries", budget=6, growth_m=0.4, side="as_given")
    victims = [make_victims(1, probe=at_distance(0.95))] * 8
    assert adaptive_way(attack, victims) == near([0.4, 0.8, 0.4, 0.6, 0.8, 0.4, 0.4, 0.4])
    assert adaptive_way(attack, [make_victims(1, blind=np.array([True]))] * 2) == near([0.0, 0.0])


@pytest.mark.parametrize(
    ("target", "expected"),
    [("joint", ("joint",)), ("joint, lstm@1/h", ("joint", "lstm@1/h")), (["cusum"], ("cusum",)), ("all", ())],
)
def test_adaptive_targets_one_or_several(target: object, expected: tuple[str, ...]) -> None:
    known = Adaptive.model_validate({"target": target}).known()
    assert (known.targets, known.own_copy) == (expected, False)
    assert Adaptive(knowledge="grey").known().own_copy


@pytest.mark.parametrize("target", ["", "joint,,cusum", [], ["all", "joint"], 3, [1]])
def test_adaptive_refuses_targets_that_mean_nothing(target: object) -> None:
    with pytest.raises(ValueError, match="expected a detector"):
        Adaptive.model_validate({"target": target})
