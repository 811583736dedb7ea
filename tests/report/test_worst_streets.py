from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from gpsec.report.worst_streets import worst_streets

from .conftest import NET


def test_the_street_of_the_departures_with_its_place(run):
    (street,) = worst_streets(run, run.rankings())
    plain = run.streets[(run.streets["defence"] == "never+none") & (run.streets["attack"] != "none")]
    judged = plain[plain["attack"].isin(run.rankings()[0].attacks)]
    assert street.edge == "e"
    assert street.departures == judged["departures"].sum() > 0
    assert street.rate == pytest.approx(3600.0 * street.departures / judged["vehicle_seconds"].sum())
    assert 0.0 < street.low < street.rate < street.high
    # This map does not say its frame: metres are from the middle of the lanes, of a degree of 111.32 km.
    assert (street.x_m, street.y_m, street.reach_m) == pytest.approx((0.0, 0.0, 50.0), abs=0.2)
    assert (street.lon_deg, street.lat_deg) == pytest.approx(NET.to_lon_lat(np.array([[50.0, 0.0]]))[0], abs=1e-6)


def test_a_defence_without_a_row_among_more_streets_than_a_byte_can_number(run, monkeypatch):
    (wanted,) = worst_streets(run, run.rankings())
    rankings, streets = run.rankings(), run.streets
    assert {ranking.best[0] for ranking in rankings} != {"never+none"}
    alone = streets[streets["defence"] == "never+none"]
    edges = pd.Categorical(alone["edge"], categories=[f"street_{number}" for number in range(300)] + ["e"])
    monkeypatch.setattr(type(run), "streets", alone.assign(edge=edges))
    assert worst_streets(run, rankings) == [replace(wanted, best=0)]
