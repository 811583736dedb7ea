"""What is said of a run in ten seconds: few lines, whatever it holds."""

import json
from io import StringIO

import pandas as pd
import pytest
from rich.console import Console

from gpsec.outcomes import brief
from gpsec.outcomes.brief import MOST_LINES, print_brief

from .test_ranking import DEFENCES, fleet, tables


@pytest.fixture
def said(tmp_path, monkeypatch):
    """Return the lines about the tables of some events."""

    def say(events, width=120, left=()):
        written = tables(events)
        head = {"scenario": "town", "profile": "carla", "attack": "bias"}
        undefended = {"defence": "never+none", "vehicle_seconds": 100.0}
        streets = [{**head, **undefended, "edge": f"e{number}"} for number in range(20)]
        places = [
            {**head, "what": "left_lane", "by": "never+none", "vehicle_id": f"v{n}", "edge": e}
            for n, e in enumerate(left)
        ]
        columns = ["scenario", "profile", "attack", "what", "by", "vehicle_id", "edge"]
        written |= {"streets": pd.DataFrame(streets), "places": pd.DataFrame(places, columns=columns)}
        monkeypatch.setattr(brief, "read_pooled", lambda folder, name: written[name])
        monkeypatch.setattr(brief, "read_table", lambda folder, name: written[name])
        (tmp_path / "manifest.json").write_text(json.dumps({"scenarios": [{"scenario": "town", "seed": 1}]}))
        stream = StringIO()
        print_brief(tmp_path, Console(file=stream, width=width, color_system=None))
        return stream.getvalue().splitlines()

    return say


def test_two_lines_for_a_scenario(said):
    seen = {"time_to_line_s": 3.0, "detection_delay_s": 1.5}
    lines = said(fleet(60, {"never+none": 50, "b+ukf": 20}, **seen))
    assert (
        lines[1] == "town · carla (60 vehicles): 83 % undefended; 0 % (0 % – 6.0 %) with a+ukf, better than every other"
    )
    expected = "  alarm before the line: 100 %, by 1.5 s; hourly 0.25 false alarms (in 2.0 h), 0.50 min without GNSS"
    assert lines[2] == expected
    assert lines[3].startswith("All tables: gpsec show ")


def test_a_street_that_stands_out_is_named(said):
    events = fleet(60, {"never+none": 50, "b+ukf": 20})
    text = " ".join(" ".join(said(events, left=["e7"] * 7 + ["e1", "e2", "e3"])).split())
    assert (
        "7 of the 10 vehicles that would have left their lane undefended did so on one street, e7, which has 5.0 %"
        in text
    )
    assert "one street" not in " ".join(said(events, left=["e1", "e2", "e3"]))


def test_a_tie_is_called_one(said):
    assert said(fleet(60, {"never+none": 50, "b+ukf": 3}))[1].endswith(
        "83 % undefended; 0 to 5.0 % with a+ukf and b+ukf (no difference)"
    )
    assert "none can be told apart from no defence" in " ".join(said(fleet(60, {"never+none": 2, "b+ukf": 2})))


@pytest.mark.parametrize("scenarios", [6, 7, 30])
def test_it_never_has_more_lines_than_it_may(said, scenarios):
    events = fleet(9, dict.fromkeys(DEFENCES, 3))
    frames = [pd.DataFrame(events).assign(scenario=f"place{number}") for number in range(scenarios)]
    lines = said(pd.concat(frames))
    assert len(lines) <= MOST_LINES + 2
    shown = sum(line.startswith("place") for line in lines)
    assert shown == min(scenarios, MOST_LINES - 1)
