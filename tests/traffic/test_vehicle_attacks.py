import libsumo
import pytest

from gpsec.core.errors import GpsecError
from gpsec.traffic.options import resolve_options
from gpsec.traffic.session import SumoSession
from gpsec.traffic.vehicle_attacks import Spoofers, carried_attacks
from gpsec.types.attack_inputs import CarriedAttack

from .helpers import CAR, ROUTE

DRIFT = '<param key="gpsec.attack" value="drift"/>'
VAN = f'<vType id="van" vClass="delivery">{DRIFT}</vType>'


def drives(name, kind, depart, more=""):
    return f'<vehicle id="{name}" type="{kind}" depart="{depart}" {more}>{ROUTE}</vehicle>'


def of(kind, name, inside, more=""):
    return f'<{kind} id="{name}" {more}>{inside}</{kind}>'


def test_what_carries_an_attack_and_how(tmp_path):
    reach = '<param key="gpsec.radius_m" value="30"/>'
    content = (
        VAN
        + of("vType", "car", '<param key="gpsec.equipped" value="1"/>')
        + of("trip", "plain", '<param key="colour" value="red"/>')
        + of("trip", "a.1", DRIFT)
        + of("flow", "east", DRIFT + '<param key="gpsec.plan" value="all"/>')
        + of("vehicle", "chaser", DRIFT + reach)
        + of("flow", "[x]", DRIFT)
        + of("poly", "zone", DRIFT)
    )
    (tmp_path / "a.rou.xml").write_text(f"<routes>{content}</routes>")
    found = carried_attacks([tmp_path / "a.rou.xml"])
    assert [(one.element, one.plan, one.states_plan, one.transmits, one.vehicles) for one in found] == [
        ("vType", "van", False, True, "van"),
        ("trip", "a.1", False, False, "a.1"),
        ("flow", "all", True, False, "east.*"),
        ("vehicle", "chaser", False, True, "chaser"),
        ("flow", "[x]", False, False, "[[]x].*"),
    ]
    assert found[3].parameters == {"gpsec.attack": "drift", "gpsec.radius_m": "30"}
    assert found[3].where == f"{tmp_path}/a.rou.xml: vehicle 'chaser'"


def test_spoofers_are_where_sumo_has_them_and_never_in_the_fleet(scenario, lane_index):
    reach = '<param key="gpsec.radius_m" value="30"/>'
    bike = f'<vType id="bike" vClass="bicycle">{DRIFT}</vType>'
    flow = f'<flow id="f" type="car" begin="2" period="5" number="2">{ROUTE}{DRIFT}{reach}</flow>'
    routes = CAR + VAN + bike + drives("b", "bike", 0) + drives("s2", "van", 1) + flow
    routes = routes.replace("<flow", drives("s1", "van", 1.5) + "<flow") + drives("f.x", "car", 4)
    plan_of = {"s1": "van", "s2": "van", "b": "bike", "f.0": "f", "f.1": "f"}
    equipped, seen = set(), set()
    with SumoSession(resolve_options(scenario(routes), seed=1), lane_index, lambda departure: True) as session:
        for frame in session.frames():
            equipped |= {departure.vehicle_id for departure in frame.departures}
            expected = {}
            for name in sorted(set(libsumo.vehicle.getIDList()) & plan_of.keys()):
                expected.setdefault(plan_of[name], []).append(libsumo.vehicle.getPosition(name))
                seen.add(name)
            assert {plan: [tuple(at) for at in at_m] for plan, at_m in frame.spoofers_m.items()} == expected
    assert seen == plan_of.keys()
    assert equipped == {"f.x"}
    assert frame.spoofers_m == {}


def test_a_spoofer_that_is_parked_goes_on(scenario, lane_index):
    stop = '<stop lane="A0B0_0" endPos="100" duration="5" parking="true"/>'
    routes = VAN + f'<vehicle id="s" type="van" depart="0">{ROUTE}{stop}</vehicle>'
    parked = []
    with SumoSession(resolve_options(scenario(routes), seed=1), lane_index, lambda departure: True) as session:
        for frame in session.frames(20.0):
            if libsumo.vehicle.isStoppedParking("s"):
                parked.append(frame.spoofers_m["van"][0].tolist())
    assert len(parked) in (50, 51)
    assert len({tuple(at) for at in parked}) == 1


def test_a_spoofer_that_is_nowhere_does_not_transmit(tmp_path, monkeypatch):
    places = {"s": (1.0, 2.0), "t": (-(2.0**30), -(2.0**30))}
    monkeypatch.setattr(libsumo.vehicle, "getPosition", places.get)
    spoofers = Spoofers([CarriedAttack(tmp_path, "vType", "van")])
    assert [spoofers.enter(name, kind) for name, kind in (("t", "van"), ("s", "van"), ("c", "car"))] == [
        True,
        True,
        False,
    ]
    assert {plan: at.tolist() for plan, at in spoofers.positions().items()} == {"van": [[1.0, 2.0]]}
    spoofers.forget("s")
    assert spoofers.positions() == {}


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (
            VAN.replace("</vType>", '<param key="gpsec.equipped" value="1"/></vType>'),
            "vType 'van': parameter 'gpsec.equipped': expected none beside 'gpsec.attack'",
        ),
        (
            of("vType", "van", '<param key="gpsec.radius_m" value="9"/>'),
            "vType 'van': unknown parameter 'gpsec.radius_m'",
        ),
        (
            of("trip", "t", '<param key="gpsec.share" value="9"/>'),
            "trip 't': parameter 'gpsec.share': expected 'gpsec.attack' beside it, found none",
        ),
    ],
)
def test_parameters_that_mean_nothing(scenario, run, content, says):
    with pytest.raises(GpsecError, match=rf"cars\.rou\.xml: {says}"):
        run(scenario(CAR + content))
    assert not libsumo.isLoaded()
