"""Where things happen, by street: the exposure of edges, and the table `streets.csv`."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats, Ints, Longs
from gpsec.core.kernels import kernel
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.metrics import poisson_interval
from gpsec.outcomes.records import cells
from gpsec.outcomes.state import OUT_OF_LANE, OutcomeState
from gpsec.outcomes.street_names import Streets
from gpsec.outcomes.study import Study
from gpsec.types.answers import Answers
from gpsec.types.constants import UNDEFENDED
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles

# Last axis of the exposure: times that a vehicle came onto the edge, and its steps there.
ENTRIES, DRIVEN_STEPS = 0, 1


class Exposure(NamedTuple):
    """Counts on E edges.

    Attributes:
        driven: (P, profiles, E, 2) entries and steps: under a plan from the beginning of the attack to the end of the
            journey, without one of the settled life.
        isolated: (profiles, E, D) steps of the settled life without an attack in which GNSS was not used.
    """

    driven: Longs
    isolated: Longs

    @classmethod
    def none(cls, study: Study, edges: int) -> "Exposure":
        """Return zeros."""
        profiles = len(study.profiles)
        return cls(
            np.zeros((len(study.plans), profiles, edges, 2), np.int64),
            np.zeros((profiles, edges, len(study.defences)), np.int64),
        )


@kernel
def count_streets(
    rows: Ints,
    edge_of_lane: Ints,
    tracks: Tracks,
    vehicles: Vehicles,
    answers: Answers,
    sums: OutcomeState,
    exposure: Exposure,
) -> None:
    """Count where tracks are, on their own side of the road; several rows share a cell: for one thread only."""
    for row in rows:
        v, plan = tracks.vehicle[row], tracks.plan[row]
        lane = vehicles.lane[v]
        counted = sums.in_event[row] if plan > 0 else tracks.settled[row]
        if lane < 0 or vehicles.against[v] or not counted:
            sums.last_edge[row] = -1
            continue
        edge, profile = edge_of_lane[lane], vehicles.profile[v]
        driven = exposure.driven[plan, profile, edge]
        driven[DRIVEN_STEPS] += 1
        if sums.last_edge[row] != edge:
            driven[ENTRIES] += 1
        sums.last_edge[row] = edge
        if plan == 0:
            for d in range(answers.isolated.shape[1]):
                exposure.isolated[profile, edge, d] += answers.isolated[row, d]


def streets_table(
    study: Study, tracks: ClosedTracks, streets: Streets, exposure: Exposure, scenario: str
) -> pd.DataFrame:
    """Return rows of edge × attack × defence: of `never+none` where there was exposure, of others where more happened.

    That is where an attack was first seen, a vehicle left its lane, or, without an attack, was without GNSS.
    """
    happened = _happened(study, tracks.events(), streets)
    parts = []
    for profile, name in enumerate(study.profiles):
        for plan, attack in enumerate(study.plans):
            driven = exposure.driven[plan, profile]
            detections, departures = (counts[plan, profile] for counts in happened)
            isolated = exposure.isolated[profile] if plan == 0 else np.zeros_like(departures)
            wanted = (detections + departures + isolated > 0) & (driven[:, DRIVEN_STEPS] > 0)[:, None]
            wanted[:, study.defence_names.index(UNDEFENDED)] = driven[:, DRIVEN_STEPS] > 0
            edge, defence = np.nonzero(wanted)
            columns: dict[str, Any] = {
                "scenario": np.full(len(edge), scenario, object),
                "profile": np.full(len(edge), name, object),
                "attack": np.full(len(edge), attack, object),
                "edge": streets.edge_id[edge],
                "defence": np.array(study.defence_names, object)[defence],
                "entries": driven[edge, ENTRIES],
                "vehicle_seconds": driven[edge, DRIVEN_STEPS] * study.step_s,
                "detections": detections[edge, defence],
                "departures": departures[edge, defence],
            }
            hours = driven[edge, DRIVEN_STEPS] * (study.step_s / 3600.0)
            columns |= _rate("departures_per_vehicle_hour", columns["departures"], hours)
            columns["isolated_seconds"] = np.where(plan == 0, isolated[edge, defence] * study.step_s, np.nan)
            parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def _rate(name: str, count: Longs, hours: Floats) -> dict[str, Any]:
    low, high = poisson_interval(count, hours, 0.95)
    return {name: count / hours, f"{name}_lo": cells(low), f"{name}_hi": cells(high)}


def _happened(study: Study, events: ClosedTracks, streets: Streets) -> tuple[Longs, Longs]:
    """Return (P, profiles, E, D) events that were first seen on each edge by each defence, and departures there."""
    shape = len(study.plans), len(study.profiles), len(streets.edge_id), len(study.defences)
    state = events.state
    found = []
    left = np.where(state.first_step[:, :, OUT_OF_LANE] >= 0, state.departed_lane, -1)
    for lane in (state.detected_lane[:, study.detector_of], left):
        counts = np.zeros(shape, np.int64)
        event, defence = np.nonzero(lane >= 0)
        edge = streets.edge[lane[event, defence]]
        np.add.at(counts, (events.plan[event], events.profile[event], edge, defence), 1)
        found.append(counts)
    return found[0], found[1]
