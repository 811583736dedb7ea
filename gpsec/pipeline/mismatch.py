"""The `[world]` section and the tapes of a scenario become what sensors, map and receivers are told."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gpsec.hdmap.error import MapError
from gpsec.hdmap.map import HDMap
from gpsec.scenario import Scenario
from gpsec.sensors.mismatch import Mismatch
from gpsec.sensors.multipath import Places, drawn_multipath, scattered_multipath
from gpsec.sensors.profiles import SensorProfile
from gpsec.sensors.sense import Sensors
from gpsec.sensors.shared_errors import SharedErrors
from gpsec.sensors.shipped_tapes import load_tape
from gpsec.sensors.tapes import Tapes, check_tape
from gpsec.sensors.visibility import Visibility
from gpsec.types.camera import LaneMistakes
from gpsec.types.drawn_zones import DrawnZone
from gpsec.types.paint import paint_file, read_paint
from gpsec.types.tapes import Tape


def map_error(scenario: Scenario) -> MapError:
    """Return by what the maps in vehicles differ from the roads."""
    world = scenario.world
    return MapError(
        seed=scenario.seed,
        shift_m=(world.map_shift_east_m, world.map_shift_north_m),
        field_m=world.map_field_m,
        field_length_m=world.map_field_length_m,
        road_m=world.map_road_m,
    )


def mismatch(scenario: Scenario) -> Mismatch:
    """Return by what sensors differ from their data sheets."""
    world = scenario.world
    return Mismatch(
        gnss_white=world.gnss_white_factor,
        gnss_slow=world.gnss_slow_factor,
        camera=world.camera_factor,
        odometer=world.odometer_factor,
        gyro=world.gyro_factor,
        heading=world.heading_factor,
        common_share=world.gnss_common_share,
    )


def tapes(scenario: Scenario, profiles: Sequence[SensorProfile], step_s: float) -> Tapes:
    """Return the tapes that are played in the place of noise.

    Raises:
        GpsecError: one cannot be played for these profiles.
    """
    names = {"gnss": scenario.fleet.gnss.tape, "camera": scenario.fleet.camera.tape}
    loaded: dict[str, Tape] = {}
    for kind, name in names.items():
        if name is not None:
            loaded[kind], _ = load_tape(name)
            check_tape(loaded[kind], f"fleet.{kind}.tape: {name}", kind, profiles, step_s)
    return Tapes(loaded.get("gnss"), loaded.get("camera"))


def visibility(
    scenario: Scenario, profiles: Sequence[SensorProfile], hd_map: HDMap, net_file: Path
) -> tuple[Visibility | None, tuple[str, ...]]:
    """Return what cameras see by place, None where all lose markings by the clock; and what the user should know.

    Raises:
        GpsecError: the file of lines beside the net is not as it should be.
    """
    return look_by_place(cameras_by_place(scenario, profiles), hd_map, net_file)


def cameras_by_place(scenario: Scenario, profiles: Sequence[SensorProfile]) -> list[bool]:
    """Return of each profile whether its cameras lose markings by place, and so behind other vehicles of the fleet."""
    camera = scenario.fleet.camera
    if camera.visibility == "profile" and camera.tape is None:
        return [profile.camera.visibility == "place" for profile in profiles]
    return [camera.visibility == "place"] * len(profiles)


def look_by_place(by_place: Sequence[bool], hd_map: HDMap, net_file: Path) -> tuple[Visibility | None, tuple[str, ...]]:
    """Return what the cameras of (P,) profiles see by place, and what the user should know, as `visibility` does."""
    if not any(by_place):
        return None, ()
    file = paint_file(net_file)
    there = file.is_file()
    stretches = read_paint(file) if there else []
    said = (
        f"lines are those of {file.name}" if there else f"there is no {file.name}: every lane has lines on both sides"
    )
    note = f"cameras lose the lane by place: {said}; only vehicles of the fleet hide it"
    return Visibility.on(hd_map, stretches, np.array(by_place)), (note,)


def lane_mistakes(scenario: Scenario) -> LaneMistakes:
    """Return how cameras err about the lane that they show."""
    world = scenario.world
    return LaneMistakes(
        hysteresis_m=world.camera_hysteresis_m,
        late_s=world.camera_late_s,
        wrong_per_h=world.camera_wrong_per_h,
        wrong_s=world.camera_wrong_s,
        blind_m=world.camera_blind_m,
    )


def make_shared_errors(
    scenario: Scenario, sensors: Sensors, hd_map: HDMap, zones: Sequence[DrawnZone]
) -> SharedErrors | None:
    """Return what is added to the fixes of all vehicles, None where that is nothing.

    Raises:
        GpsecError: a multipath zone is not as it should be.
    """
    world, seed = scenario.world, scenario.seed
    places: list[Places] = list(drawn_multipath(zones, seed))
    if world.multipath_share > 0.0:
        scattered = scattered_multipath(
            hd_map.lanes, world.multipath_share, world.multipath_m, world.multipath_length_m, seed
        )
        places += [scattered] if scattered is not None else []
    made = SharedErrors(sensors, seed, tuple(places))
    return None if made.is_quiet else made


def mismatch_note(scenario: Scenario) -> list[str]:
    """Return a sentence on what filters and detectors do not know of the world, none where they know all."""
    said = ", ".join(f"{key} = {value:g}" for key, value in scenario.world.stated().items())
    return [f"filters and detectors do not know of [world] {said}"] if said else []
