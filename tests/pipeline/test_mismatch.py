"""Every key of `[world]` does something to a run, and none of them stands for what there was before."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.pipeline.mismatch import lane_mistakes
from gpsec.scenario import Scenario
from gpsec.scenario.mismatch import WorldSection
from gpsec.types.drawn_zones import DrawnZone

from .conftest import Run, Traffic

TABLES = ("vehicles", "events", "detection", "localization")
# What each key is set to, with those that it needs beside it.
KEYS: dict[str, dict[str, float]] = {
    "gnss_white_factor": {},
    "gnss_slow_factor": {},
    "camera_factor": {},
    "odometer_factor": {},
    "gyro_factor": {},
    "heading_factor": {},
    "camera_wrong_per_h": {"camera_wrong_per_h": 600.0},
    "camera_blind_m": {"camera_blind_m": 1.5},
    "gnss_common_share": {"gnss_common_share": 0.9},
    "map_shift_east_m": {"map_shift_east_m": 0.3},
    "map_shift_north_m": {"map_shift_north_m": 0.3},
    "map_field_m": {"map_field_m": 0.3},
    "map_road_m": {"map_road_m": 0.3},
    "multipath_share": {"multipath_share": 0.3, "multipath_m": 0.5},
    "multipath_m": {"multipath_share": 0.3, "multipath_m": 1.0},
}
WIDTHS = {
    "camera_wrong_s": ({"camera_wrong_per_h": 600.0}, 3.0),
    "map_field_length_m": ({"map_field_m": 0.3}, 50.0),
    "multipath_length_m": ({"multipath_share": 0.3, "multipath_m": 0.5}, 20.0),
}


def with_world(scenario: Scenario, **keys: float) -> Scenario:
    short = {"duration_s": 20.0, "plans": scenario.plans[:1]}
    return scenario.model_copy(update={**short, "world": WorldSection(**keys)})  # type: ignore[arg-type]


def read(folder: Path) -> dict[str, bytes]:
    return {name: (folder / f"{name}.csv").read_bytes() for name in TABLES}


@pytest.fixture
def run(
    town: Scenario, traffic: Traffic, replay: Callable[[Traffic], None], go: Run
) -> Callable[..., dict[str, bytes]]:
    def run_with(**keys: float) -> dict[str, bytes]:
        replay(traffic)
        return read(go(with_world(town, **keys)))

    return run_with


# What needs a lane change, of which there is none in this traffic: tests/hdmap/test_camera_lane.py.
IN_LANE_CHANGES = {"camera_hysteresis_m": "hysteresis_m", "camera_late_s": "late_s"}


def test_every_key_is_looked_at_here() -> None:
    assert set(KEYS) | set(WIDTHS) | set(IN_LANE_CHANGES) == set(WorldSection.model_fields)


@pytest.mark.parametrize(("key", "mistake"), IN_LANE_CHANGES.items())
def test_a_camera_is_told_how_it_errs_in_lane_changes(town: Scenario, key: str, mistake: str) -> None:
    assert getattr(lane_mistakes(with_world(town, **{key: 0.7})), mistake) == 0.7


def test_every_key_does_something_and_something_of_its_own(run: Callable[..., dict[str, bytes]]) -> None:
    plain = run()
    found = {key: run(**(keys or {key: 2.0}))["vehicles"] for key, keys in KEYS.items()}
    for key, (needs, width) in WIDTHS.items():
        found[f"{key} as it is"] = run(**needs, **{key: WorldSection.model_fields[key].default + 1.0})["vehicles"]
        found[key] = run(**needs, **{key: width})["vehicles"]
    found["nothing"] = plain["vehicles"]
    alike = {key: [other for other in found if other != key and found[other] == found[key]] for key in found}
    assert {key: others for key, others in alike.items() if others} == {}


def test_no_mismatch_keeps_every_byte(run: Callable[..., dict[str, bytes]]) -> None:
    assert run(map_field_length_m=50.0, multipath_length_m=20.0, camera_wrong_s=3.0) == run()


def test_both_engines_are_in_one_world(
    town: Scenario, traffic: Traffic, replay: Callable[[Traffic], None], go: Run
) -> None:
    replay(traffic)
    world = {
        "camera_factor": 1.5,
        "map_road_m": 0.2,
        "gnss_common_share": 0.5,
        "multipath_share": 0.2,
        "multipath_m": 0.5,
    }
    scenario = with_world(town, **world).model_copy(update={"duration_s": 8.0})
    errors = [
        pd.read_csv(go(scenario.model_copy(update={"engine": engine})) / "vehicles.csv")["rmse_xy_m"]
        for engine in ("batched", "reference")
    ]
    assert np.nanmax(np.abs(errors[0] - errors[1])) < 1e-3


def drawn(zone_id: str, middle_m: Any, half_m: float, **parameters: str) -> DrawnZone:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half_m + middle_m
    stated = {f"gpsec.{k}": v for k, v in parameters.items()}
    return DrawnZone(zone_id, "polygon", corners, stated, "town.add.xml", "gpsec.multipath")


def test_a_drawn_zone_does_something_where_it_is(
    town: Scenario, traffic: Traffic, replay: Callable[[Traffic], None], go: Run
) -> None:
    found = []
    for middle_m in (np.array([1e6, 1e6]), traffic.recording.front_m[0]):
        zone = drawn("canyon", middle_m, 500.0, error_m="0.5")
        replay(replace(traffic, zones=[*traffic.zones, zone]))
        found.append(read(go(with_world(town))))
    replay(traffic)
    assert found[0] == read(go(with_world(town)))
    assert found[1] != found[0]


def test_a_drawn_zone_without_its_parameters_is_refused(
    town: Scenario, traffic: Traffic, replay: Callable[[Traffic], None], go: Run
) -> None:
    replay(replace(traffic, zones=[drawn("canyon", np.zeros(2), 50.0)]))
    with pytest.raises(
        GpsecError, match=r"^town\.add\.xml: zone 'canyon': gpsec.error_m: expected a number from 0 to 100, found none"
    ):
        go(with_world(town))
