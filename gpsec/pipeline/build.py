"""Builds the parts of a run from a scenario."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gpsec.association.associating import Associating
from gpsec.attacks.schedule import Plan, build_plans
from gpsec.attacks.vehicle_plans import plans_from_vehicles
from gpsec.attacks.zones import plans_from_zones, zone_keys
from gpsec.core.arrays import Ints
from gpsec.detection.base import Detection, Detector
from gpsec.detection.calibration import RATES
from gpsec.detection.models import build_detectors, gates_for, load_models, thresholds_for
from gpsec.detection.monitor_state import PRESETS, MonitorRules
from gpsec.detection.pairing import Sampling
from gpsec.detection.registry import DETECTORS
from gpsec.filters.noise import noise_table
from gpsec.hdmap.arrays import MapView
from gpsec.hdmap.map import HDMap, load_map
from gpsec.localization.registry import RESPONSES
from gpsec.localization.rejoin import SwitchSettings
from gpsec.localization.switch import Localization
from gpsec.localization.world import World
from gpsec.pipeline.batched import BatchedMethod
from gpsec.pipeline.filter_noise import filter_noise
from gpsec.pipeline.fleet_choice import FleetChoice, run_profiles
from gpsec.pipeline.loop_settings import LoopSettings, Move, follow_fronts
from gpsec.pipeline.mismatch import lane_mistakes, map_error, mismatch, tapes, visibility
from gpsec.pipeline.spoofers import placed_zones
from gpsec.scenario import Scenario
from gpsec.scenario.parts import use
from gpsec.scenario.traffic import sumo_options
from gpsec.sensors.multipath import MULTIPATH_KEYS
from gpsec.sensors.profiles import SensorProfile, residual_sigma_m
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.sense import Sensors
from gpsec.sensors.shared_errors import SharedErrors
from gpsec.sensors.visibility import Visibility
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.vehicle_attacks import carried_attacks
from gpsec.traffic.vehicletypes import check_type_names, named_sensors
from gpsec.traffic.zones import ZoneSource
from gpsec.types.drawn_zones import ATTACK_ZONE, MULTIPATH_ZONE, DrawnZone
from gpsec.types.method import Method
from gpsec.types.points import point_name

if TYPE_CHECKING:
    from gpsec.pipeline.pixels import PixelCameras


@dataclass(frozen=True)
class Ground:
    """What a run stands on, before the simulation is started.

    Attributes:
        options: how SUMO is run.
        choice: how the fleet is drawn.
        hd_map: the roads, with a layer for the map spacing of each profile.
        sensors: of the profiles of the run.
        world: what the filters work with.
        association: how vehicles know their lane.
        visibility: what cameras see by place, None where they lose markings by the clock.
        pixels: whose lanes come from pictures, None for nobody's.
        move: how bodies move.
        notes: what the user should know of it, one sentence each.

    """

    options: SumoOptions
    choice: FleetChoice
    hd_map: HDMap
    sensors: Sensors
    world: World
    association: Associating
    visibility: Visibility | None = None
    pixels: "PixelCameras | None" = None
    move: Move = follow_fronts
    notes: tuple[str, ...] = ()


def lay_ground(scenario: Scenario) -> Ground:
    """Check the scenario's files and load its net.

    Raises:
        GpsecError: a file is missing or wrong.

    """
    use(scenario.parts)
    options = sumo_options(scenario)
    inputs = (*options.additional_files, *options.route_files)
    for place, plan in enumerate(scenario.plans):
        check_type_names(plan.vehicle_types, inputs, f"plans.{place}.vehicle_types")
    named = named_sensors(inputs)
    names = run_profiles(scenario.fleet.profile, named)
    choice = FleetChoice(scenario.seed, scenario.fleet.equipped_share, scenario.fleet.profile, names)
    profiles = tuple(PROFILES[name] for name in names)
    spacings_m = tuple(profile.map_spacing_m for profile in profiles)
    hd_map = load_map(options.net_file, spacings_m, error=map_error(scenario))
    layers = np.array([hd_map.layer(profile.map_spacing_m) for profile in profiles], np.int32)
    noise = noise_table([filter_noise(profile, options.step_s) for profile in profiles])
    association = Associating(scenario.fleet.association, hd_map.roads(layers), noise, options.step_s)
    view = MapView(hd_map.lanes, hd_map.index, association.mode, layers)
    world = World(view, noise, options.step_s)
    sensors = Sensors(profiles, options.step_s, mismatch(scenario), tapes(scenario, profiles, options.step_s))
    visible, notes = visibility(scenario, profiles, hd_map, options.net_file)
    ground = Ground(options, choice, hd_map, sensors, world, association, visibility=visible, notes=notes)
    return _with_pixels(ground, scenario) if scenario.fleet.camera.source == "image" else ground


def _with_pixels(ground: Ground, scenario: Scenario) -> Ground:
    from gpsec.pipeline.pixels import pixel_cameras, pixel_note  # late: no other run needs the image processing

    cameras = pixel_cameras(scenario, ground.hd_map, ground.sensors)
    return replace(ground, pixels=cameras, notes=(*ground.notes, pixel_note(scenario)))


def make_detection(scenario: Scenario, ground: Ground) -> Detection:
    """Return the detectors of a run: those of the scenario, then the bounds that its defences use.

    Raises:
        GpsecError: there is no model or threshold for one of them.

    """
    points = scenario.points()
    names = list(dict.fromkeys(name for name, _ in points))
    profiles, association = ground.choice.profiles, scenario.fleet.association
    models = None if scenario.detection.models is None else load_models(Path(scenario.detection.models))
    built = dict(zip(names, build_detectors(names, profiles, association, models), strict=True))
    detectors = tuple(built[name] for name, _ in points)
    monitor = None
    if any(isinstance(detector, Detector) and detector.reads_monitor for detector in detectors):
        world, gates = ground.world, gates_for(profiles, association, models)
        monitor = MonitorRules(world.step_s, world.noise, gates, *PRESETS[scenario.detection.monitor])
    return Detection(
        names=tuple(point_name(*point) for point in points),
        rates=tuple(rate if DETECTORS[name].threshold is None else "" for name, rate in points),
        origins=tuple(
            "fixed" if DETECTORS[name].threshold is not None else "model" if RATES[rate].model else "counted"
            for name, rate in points
        ),
        detectors=detectors,
        thresholds=thresholds_for(points, profiles, association, models),
        scale_m=np.array([residual_sigma_m(PROFILES[name]) for name in profiles]),
        sampling=sampling_of([PROFILES[name] for name in profiles], ground.options.step_s),
        monitor=monitor,
    )


def sampling_of(profiles: Sequence[SensorProfile], step_s: float) -> Sampling:
    """Return how old samples of the sensors of (P,) profiles may be of which a residual is formed."""
    return Sampling.of(step_s, [one.gnss.rate_hz for one in profiles], [one.camera.rate_hz for one in profiles])


def make_localization(scenario: Scenario, world: World, detectors: Sequence[str]) -> Localization:
    """Return the filters of the scenario's defences."""
    responses = {name: RESPONSES[name]() for name in {defence.response for defence in scenario.defences}}
    columns = np.array([detectors.index(defence.point) for defence in scenario.defences], np.int32)
    settings = SwitchSettings(
        scenario.localization.hold_s,
        scenario.localization.rejoin_s,
        scenario.localization.outage_s,
        scenario.localization.rollback_s,
    )
    return Localization(columns, [responses[defence.response] for defence in scenario.defences], world, settings)


def drawn_zones(session: ZoneSource) -> list[DrawnZone]:
    """Return what is drawn in a scenario: attack zones and places of multipath.

    Raises:
        GpsecError: one has a parameter that is not known, or would have no effect.

    """
    return session.zones({ATTACK_ZONE: zone_keys(), MULTIPATH_ZONE: MULTIPATH_KEYS})


def make_plans(scenario: Scenario, ground: "Ground", options: SumoOptions, zones: Sequence[DrawnZone]) -> list[Plan]:
    """Return the attack plans of the scenario, of the zones that are drawn in it, and those that vehicles carry.

    In a world of the closed loop there is its own plan alone.

    Raises:
        GpsecError: one of them is not as it should be.

    """
    drawn = plans_from_zones(zones)
    inputs = (*options.additional_files, *options.route_files)
    carried = plans_from_vehicles(carried_attacks(inputs))
    placed = placed_zones(scenario.plans, ground.hd_map, scenario.name)
    plans = build_plans(scenario.plans, drawn, carried, placed, config_file=scenario.name)
    world = scenario.closed_loop.world
    return plans if world is None else [plan for plan in plans if plan.name == world.plan]


def loop_settings(
    scenario: Scenario,
    ground: Ground,
    step_s: float,
    shared: SharedErrors | None = None,
    targets: Mapping[str, Ints] | None = None,
) -> LoopSettings:
    """Return what the loop needs to know of a scenario whose simulation takes steps of `step_s`."""
    return LoopSettings(
        seed=scenario.seed,
        step_s=step_s,
        origin_s=ground.options.begin_s + step_s,
        settle_s=scenario.fleet.settle_s,
        hd_map=ground.hd_map,
        sensors=ground.sensors,
        profile_of=ground.choice.profile,
        shared=shared,
        mistakes=lane_mistakes(scenario),
        visibility=ground.visibility,
        pixels=ground.pixels,
        move=ground.move,
        forks=scenario.closed_loop.world is None,
        targets=targets or {},
    )


def make_method(scenario: Scenario, ground: Ground, detection: Detection, plans: Sequence[Plan]) -> Method:
    """Return the engine that the scenario asks for, with what the attackers of its plans need."""
    localization = make_localization(scenario, ground.world, detection.names)
    known = [plan.attack.known() for plan in plans]
    copies = any(one is not None and one.own_copy for one in known)
    if scenario.engine == "reference":
        from gpsec.reference.method import ReferenceMethod

        return ReferenceMethod(ground.hd_map, ground.world, ground.association, detection, localization, copies=copies)
    return BatchedMethod(ground.world, ground.association, detection, localization, copies=copies)
