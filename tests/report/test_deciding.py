"""The page for deciding says what tests have found, and no more."""

import pytest

from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.ranking import rankings
from gpsec.report.deciding import advice, decision_figure, decision_tables
from tests.outcomes.test_ranking import fleet, tables


class Run:
    """The tables that the page is made from."""

    def __init__(self, out_of):
        self.tables = tables(fleet(60, out_of))
        rate = "false_alarms_per_vehicle_hour"
        self.detection = self.tables["detection"].assign(
            **{f"{rate}_lo": 0.1, f"{rate}_hi": 0.9, "threshold": 12.0, "rate": "0.1/h"}
        )
        self.ranked = rankings(self.tables, Bootstrap(1, 1000, 0.95))


def said(out_of, fleet_hours=1000.0):
    run = Run(out_of)
    (found,) = advice(run, run.ranked, fleet_hours)
    return " ".join(found.sentences)


def test_a_winner_is_taken():
    text = said({"never+none": 50, "b+ukf": 20})
    assert text.startswith("Take a+ukf: it leaves fewer vehicles out of their lane than every other defence here.")
    assert "a+ukf: 250 false alarms a day (100 – 900), 500 minutes without GNSS." in text


def test_the_fleet_is_that_which_is_stated():
    assert "a+ukf: 25.0 false alarms a day (10.0 – 90.0)" in said({"never+none": 50, "b+ukf": 20}, 100.0)


def test_what_has_no_detector_has_neither_threshold_nor_false_alarms():
    run = Run({"never+none": 50, "b+ukf": 20})
    (table,) = decision_tables(run, run.ranked, 1000.0)
    cells = {row.name: [cell.text for cell in row.cells] for row in table.rows}
    assert cells["never+none"][:2] == ["none", "none"]
    assert cells["a+ukf"][:2] == ["12.0", "250"]


def test_no_difference_is_said():
    assert "No difference between a+ukf and b+ukf in vehicles out of their lane, of 60" in said({"never+none": 50})


def test_where_nothing_helps_it_says_so():
    text = said({"never+none": 2})
    assert text.startswith("No difference: 60 vehicles do not tell any defence from none.")
    assert "Take" not in text


def test_another_rate_that_keeps_more_in_their_lane_says_its_price():
    text = said({"never+none": 60, "a+ukf": 20, "b+ukf": 40})
    assert "a@1e-3/sample+ukf: fewer out of their lane, for 0.00 more false alarms a day." in text
    assert "a@1e-3/sample+ukf: no difference" in said({"never+none": 60, "b+ukf": 40})


def test_each_point_has_its_bounds():
    run = Run({"never+none": 50, "b+ukf": 20})
    series = {one.name: one for one in decision_figure(run, run.ranked, 1000.0).series}
    assert list(series) == ["a+ukf", "b+ukf"]
    assert list(series["b+ukf"].x) == [250.0]
    assert series["b+ukf"].y == pytest.approx([1 / 3])
    assert (list(series["b+ukf"].x_low), list(series["b+ukf"].x_high)) == ([100.0], [900.0])
    (table,) = decision_tables(run, run.ranked, 1000.0)
    assert [(row.attack, row.name) for row in table.rows][:2] == [("best", "a+ukf"), ("", "a@1e-3/sample+ukf")]
