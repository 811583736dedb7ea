"""A run in which nothing happens but that every kernel is called: to compile them before they are needed."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.pipeline.build import lay_ground, make_detection, make_localization
from gpsec.pipeline.run import run_scenario
from gpsec.scenario import Scenario
from gpsec.traffic.offline import OfflineTraffic
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.source import Departure, Equip, Frame
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# Attacks begin in the second step and end in the third; then everybody leaves.
_STEPS = 4
_VEHICLES = 20


class Extras(OfflineTraffic):
    """Vehicles that stand about; implements `gpsec.pipeline.interfaces.Traffic`.

    Attributes:
        step_s: length of a step.

    """

    def __init__(self, options: SumoOptions, lane_index: Mapping[str, int], equip: Equip) -> None:
        super().__init__(options)
        self.step_s = options.step_s

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        """Yield the steps, whatever the duration."""
        rows: Ints = np.arange(_VEHICLES, dtype=np.int32)
        for step in range(_STEPS):
            entering = [_extra(row) for row in rows.tolist()] if step == 0 else []
            left = rows.tolist() if step == _STEPS - 1 else []
            rows = rows[len(left) :]
            yield Frame(
                step=step,
                time_s=self.options.begin_s + (step + 1) * self.step_s,
                left=left,
                departures=entering,
                rows=rows,
                front_m=np.zeros((len(rows), 2)),
                lane=np.zeros(len(rows), np.int32),
                on_road=len(rows),
            )


def _extra(row: int) -> Departure:
    return Departure(
        row=row,
        vehicle_id=f"extra {row}",
        vehicle_type="",
        vehicle_class="passenger",
        length_m=4.5,
        width_m=1.8,
        yaw_rad=0.0,
        speed_mps=0.0,
        equipped_share=None,
        sensors=None,
    )


def warm_up(scenario: Scenario, folder: Path) -> None:
    """Run `scenario` with extras instead of traffic, and write its tables, which mean nothing, into `folder`."""
    _correct(scenario)  # first, since it takes longest to compile: what is left divides more evenly
    run_scenario(_hurried(scenario), folder, lambda progress: None, Extras)


def _correct(scenario: Scenario) -> None:
    """Let every response correct an estimate and take GNSS back; no filter of the extras is ever isolated by itself."""
    ground = lay_ground(scenario)
    localization = make_localization(scenario, ground.world, make_detection(scenario, ground).names)
    first, threads = np.zeros(1, np.int32), Threads()
    tracks, vehicles, seen = Table(Tracks).now, Table(Vehicles).now, Table(Measurements).now
    for place, family in enumerate(localization.families):
        for number, _ in family.responses:
            state = localization.new_state(1)
            state.reset(first)
            for rows in state.families:
                rows.activate(first, 1)
            branches = state.families[place].now
            branches.response[:], branches.entered[:], state.cells.parts[:] = number, True, True
            localization.correct(state, first, tracks, vehicles, seen, threads)


def _hurried(scenario: Scenario) -> Scenario:
    """Return the scenario with attacks on everybody at once."""
    at_once = {
        "share": 1.0,
        "vehicle_types": (),
        "vehicles": (),
        "zone": None,
        "begin_s": 0.0,
        "end_s": None,
        "start_after_s": (0.0, 0.0),
        "duration_s": (0.1, 0.1),
    }
    return scenario.model_copy(
        update={
            "engine": "batched",
            "log_steps": False,
            "threads": 1,
            "fleet": scenario.fleet.model_copy(update={"settle_s": 0.0}),
            "outcomes": scenario.outcomes.model_copy(update={"bootstrap": 2}),
            "plans": tuple(plan.model_copy(update=at_once) for plan in scenario.plans),
            "closed_loop": scenario.closed_loop.model_copy(update={"world": None}),  # extras cannot react
        }
    )
