from pathlib import Path

from gpsec.paper.design import (
    AS_WRITTEN,
    EVALUATION,
    NONE,
    ODOMETER_FACTORS,
    PIN_SEEDS,
    SEEDS,
    SET_UPS,
    SIMULATED,
    Pinned,
)
from gpsec.paper.studies import Studies
from gpsec.scenario.networks import TRAINING_NETWORKS

STUDIES = Studies(Path(__file__).parents[2] / "scenarios")
PINNED = Pinned(dict.fromkeys(SET_UPS, 1.5), dict.fromkeys(SET_UPS, 2.0))


def test_nothing_that_is_scored_was_trained_on():
    assert not set(EVALUATION) & set(TRAINING_NETWORKS)
    assert min(*SEEDS, *PIN_SEEDS) > 3  # training and calibration have seeds 2 and 3
    assert not set(SEEDS) & set(PIN_SEEDS)
    for group, scenarios in STUDIES.groups(PINNED).items():
        for scenario in scenarios:
            assert scenario.seed in SEEDS
            if group[0] != "mixed":  # which holds the column of the training networks
                assert scenario.sumocfg.stem in EVALUATION


def test_names_are_distinct_and_counted():
    scenarios = [scenario for group in STUDIES.groups(PINNED).values() for scenario in group]
    names = [scenario.name for scenario in (*STUDIES.pin(), *STUDIES.benign(), *scenarios)]
    assert len(set(names)) == len(names) == STUDIES.count


def test_all_detectors_see_the_same_attacks_at_the_same_rate():
    for profile in SET_UPS:
        (first, *others) = STUDIES.main(profile, PINNED)
        plans = {plan.name: plan.parameters for plan in first.plans}
        assert plans["constant_bias"].bias_m == 2.0
        assert plans["stealth"].delta == 1.5
        assert first.detection.rates == ("1e-3/sample",)
        assert all(other.plans == first.plans for other in others)
        assert all(plan.share == 1.0 for plan in first.plans)


def test_the_paper_as_written_has_equal_parts_and_the_nearest_lane():
    for profile in (*SET_UPS, *SIMULATED.values()):
        for scenario in STUDIES.groups(PINNED)["written", profile]:
            assert scenario.fleet.association == "nearest"
            assert scenario.fleet.profile == {profile: 1.0}
            assert scenario.detection.detectors == ("cusum", "isolation_forest", "lstm")
            assert {NONE, AS_WRITTEN} <= {(defence.detector, defence.response) for defence in scenario.defences}
            bias, _ = (plan.parameters for plan in scenario.plans)
            assert (bias.frame, bias.direction_deg, bias.side, bias.bias_m) == ("world", 45.0, "as_given", 2.0)


def test_the_sweep_of_the_odometer_scales_what_filters_do_not_know():
    factors = [STUDIES.odometer(factor, PINNED).world.odometer_factor for factor in ODOMETER_FACTORS]
    assert factors == list(ODOMETER_FACTORS)
