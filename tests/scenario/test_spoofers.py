"""A spoofer at a place, from coordinates or an edge, without netedit."""

from dataclasses import replace

import numpy as np
import pytest

from gpsec.attacks.plans import plan_config
from gpsec.attacks.schedule import build_plans
from gpsec.console.spoofing import with_spoofers
from gpsec.core.errors import GpsecError
from gpsec.core.geo import Projector
from gpsec.pipeline.spoofers import placed_zones
from gpsec.scenario import load_scenario
from gpsec.testing.rig import straight_road

UTM = Projector("+proj=utm +zone=32 +datum=WGS84 +units=m", (-600_000.0, -5_790_000.0))


@pytest.fixture(scope="module")
def road():
    """A road towards east, on which lanes run from the origin on."""
    return replace(straight_road(), projector=UTM)


@pytest.fixture(scope="module")
def town(repository):
    return load_scenario(repository / "scenarios" / "town")


def plan(**keys):
    return plan_config({"attack": "drift", **keys}, "gpsec.toml: plans[0]")


def test_coordinates_become_a_zone_in_the_frame_of_the_net(road):
    line = road.centre_line(0)
    beside = line[0] + [10.0, 30.0]
    at = UTM.to_lon_lat(beside).tolist()
    config = plan(at=at, radius_m=40.0)
    zones = placed_zones([config], road, "mine")
    (made,) = build_plans([config], placed=zones)
    assert made.zone is not None
    away = np.array([[30.0, 0.0], [50.0, 0.0]])
    assert list(made.zone.contains(beside + away)) == [True, False]


def test_an_edge_stands_for_its_middle(road):
    line, edge = road.centre_line(0), road.lane_ids[0].rpartition("_")[0]
    (zone,) = placed_zones([plan(edge=edge, radius_m=5.0)], road, "mine").values()
    assert zone.shape_m[0] == pytest.approx(0.5 * (line[0] + line[-1]))


def test_a_place_off_the_roads_names_the_nearest(road):
    at = UTM.to_lon_lat(road.centre_line(0)[0] + [10.0, 300.0]).tolist()
    with pytest.raises(GpsecError, match=r"mine: plans\[0\]: at: .* found the nearest one, of edge '.*', 300 m away"):
        placed_zones([plan(at=at, radius_m=40.0)], road, "mine")


def test_a_net_without_a_projection_asks_for_an_edge(road):
    nowhere = replace(road, projector=Projector("!"))
    with pytest.raises(GpsecError, match="found one without a projection; name an edge instead"):
        placed_zones([plan(at=[10.0, 52.0], radius_m=40.0)], nowhere, "mine")


def test_an_unknown_edge_is_refused(road):
    with pytest.raises(GpsecError, match="edge: expected an edge of the net, found 'nowhere'"):
        placed_zones([plan(edge="nowhere", radius_m=40.0)], road, "mine")


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"at": [10.0, 52.0]}, "radius_m: expected the reach of the spoofer"),
        ({"radius_m": 20.0}, "radius_m: expected none without `at` or `edge`"),
        ({"at": [10.0, 52.0], "edge": "a", "radius_m": 20.0}, "edge: expected one place, found `at` beside it"),
        (
            {"edge": "a", "radius_m": 20.0, "duration_s": [1.0, 2.0]},
            "duration_s: expected none beside the place of a spoofer",
        ),
        ({"at": [10.0, 152.0], "radius_m": 20.0}, "expected [longitude, latitude] in degrees"),
        ({"at": [10.0], "radius_m": 20.0}, "expected [longitude, latitude] in degrees"),
    ],
)
def test_what_does_not_go_together_is_refused(keys, said):
    with pytest.raises(GpsecError) as caught:
        plan(**keys)
    assert said in str(caught.value)


def test_the_option_makes_a_plan_that_spares_nobody(town):
    found = with_spoofers(town, ["10.5, 52.3, 60", "10.6,52.3,50,5,25,stealth"], only_zones=True)
    first, second = found.plans
    assert (first.name, first.attack, first.at, first.radius_m, first.share) == (
        "roadside",
        "drift",
        (10.5, 52.3),
        60.0,
        1.0,
    )
    assert (second.name, second.attack, second.begin_s, second.end_s) == ("roadside2", "stealth", 5.0, 25.0)
    assert len(with_spoofers(town, ["10.5,52.3,60"], only_zones=False).plans) == len(town.plans) + 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("10.5,52.3", "expected lon,lat,radius_m[,begin,end,attack], found 2 values"),
        ("10.5,north,60", "found 'north' in place of a number"),
        ("10.5,52.3,", "found an empty place or radius"),
        ("10.5,52.3,60,,,drft", "did you mean 'drift'?"),
        ("10.5,52.3,60,30,20", "end_s: expected later than begin_s"),
    ],
)
def test_a_text_of_another_form_is_refused(town, text, said):
    with pytest.raises(GpsecError) as caught:
        with_spoofers(town, [text], only_zones=False)
    assert f"--spoofer {text}"[:20] in str(caught.value)
    assert said in str(caught.value)
