"""Zones as they come out of a drawing: geometry by hand, and what a bad parameter gets."""

import numpy as np
import pytest

from gpsec.attacks.constant_bias import ConstantBias
from gpsec.attacks.registry import ATTACKS
from gpsec.attacks.zones import Zone, plans_from_zones, zone_keys
from gpsec.core.errors import GpsecError
from gpsec.types.drawn_zones import DrawnZone

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
POINT = np.array([[3.0, 4.0]])


def draw(kind="polygon", shape_m=SQUARE, parameters=None, zone_id="z1") -> DrawnZone:
    return DrawnZone(zone_id, kind, shape_m, parameters or {}, "town.add.xml")


def test_inside_a_polygon() -> None:
    """An L: the 10 m square without its upper right quarter."""
    corner = Zone("l", np.array([[0, 0], [10, 0], [10, 5], [5, 5], [5, 10], [0, 10.0]]))
    position = np.array([[1.0, 1.0], [9.0, 4.0], [9.0, 6.0], [4.0, 9.0], [6.0, 6.0], [-1.0, 5.0], [4.99, 9.99]])
    assert corner.contains(position).tolist() == [True, True, False, True, False, False, True]


def test_within_a_radius() -> None:
    disc = Zone("d", POINT, radius_m=5.0)
    position = np.array([[0.0, 0.0], [3.0, 9.0], [3.0, 9.01], [-2.0, 4.0], [7.0, 8.0]])
    assert disc.contains(position).tolist() == [True, True, False, True, False]


def test_nobody_asked() -> None:
    for zone in (Zone("p", SQUARE), Zone("d", POINT, radius_m=5.0)):
        assert zone.contains(np.zeros((0, 2))).shape == (0,)


def test_every_parameter_of_every_attack_is_known() -> None:
    keys = zone_keys()
    assert keys[:5] == ["gpsec.attack", "gpsec.begin", "gpsec.end", "gpsec.share", "gpsec.radius_m"]
    assert set(keys[5:]) == {f"gpsec.{name}" for attack in ATTACKS.values() for name in attack.model_fields}
    assert len(keys) == len(set(keys))


def test_a_polygon_becomes_a_plan() -> None:
    drawn = draw(
        parameters={
            "gpsec.attack": "constant_bias",
            "gpsec.begin": "60",
            "gpsec.end": "300",
            "gpsec.share": "0.25",
            "gpsec.bias_m": "2.5",
            "gpsec.side": "as_given",
            "gpsec.rate_mps": "",  # libsumo's answer for a parameter that is not there
            "color": "red",
        }
    )
    [(config, zone, _)] = plans_from_zones([drawn])
    assert (config.name, config.zone, zone.zone_id) == ("z1", "z1", "z1")
    assert (config.begin_s, config.end_s, config.share) == (60.0, 300.0, 0.25)
    assert config.parameters == ConstantBias(bias_m=2.5, side="as_given")
    assert zone.radius_m is None
    assert zone.contains(np.array([[5.0, 5.0]]))[0]


def test_a_point_becomes_a_plan_with_defaults() -> None:
    drawn = draw("point", POINT, {"gpsec.attack": "jamming", "gpsec.radius_m": "150"})
    [(config, zone, _)] = plans_from_zones([drawn])
    assert (config.begin_s, config.end_s, config.share) == (0.0, None, 1.0)
    assert zone.radius_m == 150.0


BOW_TIE = np.array([[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]])
BIAS = {"gpsec.attack": "constant_bias"}
REFUSED = [
    (draw(), "gpsec.attack: expected one of constant_bias, "),
    (draw(parameters={"gpsec.attack": "driftt"}), "unknown attack 'driftt': did you mean 'drift'?"),
    (
        draw(parameters=BIAS | {"gpsec.bias": "2"}),
        "unknown key 'gpsec.bias' for attack 'constant_bias': did you mean 'gpsec.bias_m'?",
    ),
    (draw(parameters=BIAS | {"gpsec.beginn": "2"}), "did you mean 'gpsec.begin'?"),
    (
        draw(parameters=BIAS | {"gpsec.rate_mps": "0.1"}),
        "unknown key 'gpsec.rate_mps' for attack 'constant_bias'",
    ),
    (draw(parameters=BIAS | {"gpsec.bias_m": "far"}), "gpsec.bias_m: expected a valid number"),
    (
        draw(parameters=BIAS | {"gpsec.bias_m": "-1"}),
        "gpsec.bias_m: expected a number greater than 0, found '-1'",
    ),
    (draw(parameters=BIAS | {"gpsec.begin": "noon"}), "gpsec.begin: expected a number, found 'noon'"),
    (draw(parameters=BIAS | {"gpsec.end": "nan"}), "gpsec.end: expected a number, found 'nan'"),
    (
        draw(parameters=BIAS | {"gpsec.begin": "9", "gpsec.end": "8"}),
        "gpsec.end: expected later than gpsec.begin = 9, found 8",
    ),
    (draw(parameters=BIAS | {"gpsec.end": "0"}), "gpsec.end: expected later than gpsec.begin = 0, found 0"),
    (draw(parameters=BIAS | {"gpsec.share": "50"}), "gpsec.share: expected a number from 0 to 1, found 50"),
    (draw(parameters=BIAS | {"gpsec.radius_m": "5"}), "gpsec.radius_m: expected none for a polygon"),
    (draw("point", POINT, BIAS), "gpsec.radius_m: expected a number of metres for a point, found none"),
    (
        draw("point", POINT, BIAS | {"gpsec.radius_m": "0"}),
        "gpsec.radius_m: expected a number greater than 0, found 0",
    ),
    (
        draw(shape_m=SQUARE[[0, 1, 0]], parameters=BIAS),
        "shape: expected a polygon of at least 3 corners, found 2",
    ),
    (
        draw(shape_m=BOW_TIE, parameters=BIAS),
        "shape: expected a polygon that does not cross itself, found Self-intersection",
    ),
    (draw(zone_id="none", parameters=BIAS), "name: 'none' is kept for vehicles without an attack"),
]


@pytest.mark.parametrize(("drawn", "problem"), REFUSED, ids=[problem for _, problem in REFUSED])
def test_a_bad_zone_is_refused_in_one_sentence(drawn: DrawnZone, problem: str) -> None:
    with pytest.raises(GpsecError) as caught:
        plans_from_zones([drawn])
    assert str(caught.value).startswith(f"town.add.xml: zone '{drawn.zone_id}': ")
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)
