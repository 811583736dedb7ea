"""A street stands out by what exposure does not account for; every count is by hand."""

import pandas as pd
import pytest
from scipy.stats import binom

from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.concentration import gatherings
from gpsec.outcomes.ranking import rankings

from .test_ranking import fleet, tables


class Run:
    """Twenty streets, driven for so many seconds each; departures of vehicles with never+none."""

    def __init__(self, departures, seconds):
        self.ranked = rankings(tables(fleet(60, {"never+none": 50, "b+ukf": 20})), Bootstrap(1, 500, 0.95))
        head = {"scenario": "town", "profile": "carla", "attack": "bias"}
        self.streets = pd.DataFrame(
            [
                {**head, "edge": edge, "defence": "never+none", "vehicle_seconds": time}
                for edge, time in {**{f"e{number}": 100.0 for number in range(19)}, **seconds}.items()
            ]
        )
        self.places = pd.DataFrame(
            [
                {**head, "vehicle_id": f"v{number}", "what": "left_lane", "by": "never+none", "edge": edge}
                for number, edge in enumerate(departures)
            ]
        )


def found(departures, seconds):
    run = Run(departures, seconds)
    return gatherings({"streets": run.streets, "places": run.places}, run.ranked[0])


def test_seven_of_ten_on_one_street_of_twenty_stand_out():
    (one,) = found(["bad"] * 7 + ["e1", "e2", "e3"], {"bad": 100.0})
    assert (one.edge, one.defence, one.vehicles, one.of) == ("bad", "never+none", 7, 10)
    assert one.exposure_share == pytest.approx(0.05)
    assert one.chance == pytest.approx(20 * binom.sf(6, 10, 0.05))
    assert one.sentence().startswith(
        "7 of the 10 vehicles that would have left their lane undefended did so on one street, bad, which has 5.0 % of"
    )


def test_a_street_on_which_most_is_driven_does_not():
    assert found(["busy"] * 7 + ["e1", "e2", "e3"], {"busy": 4000.0}) == []


def test_departures_that_are_spread_do_not():
    assert found([f"e{number}" for number in range(10)], {"bad": 100.0}) == []


def test_two_vehicles_are_no_place():
    assert found(["bad"] * 2, {"bad": 0.1}) == []


def test_a_vehicle_counts_once_a_street_and_junctions_do_not_count():
    run = Run(["bad"] * 7 + ["e1"], {"bad": 100.0, ":turn": 1e6})
    run.places = pd.concat([run.places, run.places.assign(attack="bias")])
    (one,) = gatherings({"streets": run.streets, "places": run.places}, run.ranked[0])
    assert (one.vehicles, one.of) == (7, 8)
    assert one.exposure_share == pytest.approx(0.05)
