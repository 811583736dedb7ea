"""The impact of attacks: what goes unseen, of one run and over seeds."""

import numpy as np
import pandas as pd
import pytest

from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.naming import seeded_name
from gpsec.running.impact import IMPACT_COLUMNS, impact_table, median_ranks, weighted_medians

OFF_M = {"joint": [0.1, 0.2, 0.3, 0.4, 0.9, 0.8], "never": [1.0, 2.0, 3.0, 4.0, 9.0, 8.0]}


def tables(scenarios: list[str], alarms: int = 2) -> dict[str, pd.DataFrame]:
    """Six vehicles of each scenario, each attacked once; half of them were seen by joint."""
    events, vehicles, detection = [], [], []
    for shift, scenario in enumerate(scenarios):
        for detector, offs in OFF_M.items():
            key = {"scenario": scenario, "profile": "carla", "detector": detector, "defence": f"{detector}+none"}
            for number, off_m in enumerate(offs):
                who = {"vehicle_id": str(number)}
                seen = detector == "joint" and number % 2 == 0
                events.append(
                    key
                    | who
                    | {"attack": "bias", "detected": seen, "max_undetected_deviation_m": off_m + shift}
                    | {"max_undetected_deviation_s": 10.0 * off_m, "line_touched_unseen": off_m > 0.8}
                    | {"out_of_lane_unseen": off_m > 1.5}
                )
                false = alarms if detector == "joint" and number == 0 else 0
                vehicles.append(key | who | {"attack": "none", "false_alarms": false, "vehicle_seconds": 360.0})
            rate = {"false_alarms_per_vehicle_hour": 3.3, "false_alarms_per_vehicle_hour_lo": 1.0}
            rate |= {"false_alarms_per_vehicle_hour_hi": 7.0, "rate": "0.1/h" if detector == "joint" else ""}
            detection.append(key | {"attack": "bias"} | rate)
    found = {"events": events, "vehicles": vehicles, "detection": detection}
    return {name: pd.DataFrame(rows) for name, rows in found.items()}


def test_of_one_run() -> None:
    table = impact_table(tables(["lane"]), Bootstrap(1))
    assert list(table.columns) == IMPACT_COLUMNS
    assert table[["scenario", "attack", "detector", "rate", "n_runs", "n_events"]].to_numpy().tolist() == [
        ["lane", "bias", "joint", "0.1/h", 1, 6],
        ["lane", "bias", "never", "", 1, 6],
    ]
    joint = table.iloc[0]
    # Of 0.1, 0.2, 0.3, 0.4, 0.8, 0.9 m; six values are all that an interval of the median at 95 % can be made of.
    assert joint["max_undetected_deviation_median_m"] == pytest.approx(0.35)
    assert (joint["max_undetected_deviation_median_m_lo"], joint["max_undetected_deviation_median_m_hi"]) == (0.1, 0.9)
    assert joint["max_undetected_deviation_median_s"] == pytest.approx(3.5)
    assert (joint["detected_share"], joint["line_touched_unseen_share"]) == (0.5, pytest.approx(1 / 6))
    assert joint["out_of_lane_unseen_share"] == 0.0
    assert joint["out_of_lane_unseen_share_hi"] > 0.3  # Wilson's interval of 0 of 6
    # Of one run, the false alarms are those of detection.csv.
    assert joint["false_alarms_per_vehicle_hour"] == 3.3


def test_over_seeds_whole_runs_are_drawn() -> None:
    names = [seeded_name("lane", seed) for seed in (1, 2, 3)]
    table = impact_table(tables(names), Bootstrap(1, 400))
    joint = table[table["detector"] == "joint"].iloc[0]
    assert (joint["scenario"], joint["n_runs"], joint["n_events"]) == ("lane", 3, 18)
    # Runs lie a metre apart: with vehicles drawn alone, the median would be known better.
    assert joint["max_undetected_deviation_median_m_lo"] < 0.9
    assert joint["max_undetected_deviation_median_m_hi"] > 2.0
    # Six alarms in 3 x 6 vehicles of a tenth of an hour.
    assert joint["false_alarms_per_vehicle_hour"] == pytest.approx(6 / 1.8)
    assert joint["false_alarms_per_vehicle_hour_lo"] < 6 / 1.8 < joint["false_alarms_per_vehicle_hour_hi"]


def test_of_no_false_alarm_there_is_a_bound() -> None:
    names = [seeded_name("lane", seed) for seed in (1, 2)]
    joint = impact_table(tables(names, alarms=0), Bootstrap(1, 100)).iloc[0]
    assert joint["false_alarms_per_vehicle_hour"] == 0.0
    # -ln 0.025 in 1.2 vehicle-hours.
    assert joint["false_alarms_per_vehicle_hour_hi"] == pytest.approx(3.688879 / 1.2)


def test_medians_of_what_is_drawn() -> None:
    found = weighted_medians(np.array([3.0, 1.0, 2.0]), np.array([[1.0, 1.0, 1.0], [3.0, 1.0, 0.0], [0.0, 0.0, 0.0]]))
    assert found.value[:2].tolist() == [2.0, 3.0]
    assert found.known.tolist() == [True, True, False]


@pytest.mark.parametrize(("count", "ranks"), [(5, None), (6, (0, 5)), (20, (5, 14)), (100, (39, 60))])
def test_ranks_that_hold_the_median(count: int, ranks: tuple[int, int] | None) -> None:
    """By the binomial distribution, the interval of these ranks holds it with a probability of 0.95 at least."""
    assert median_ranks(count, 0.95) == ranks
