"""The table `places.csv`: where attacks began, where they were seen, where vehicles would have left their lane."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from gpsec.core.geo import Projector
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.places import ATTACK_BEGAN, DETECTED, LEFT_LANE
from gpsec.outcomes.state import OUT_OF_LANE
from gpsec.outcomes.street_names import Streets
from gpsec.outcomes.study import Study


class When(NamedTuple):
    """Seed of a run, and the simulated time of its step 0."""

    seed: int
    origin_s: float


def places_table(
    study: Study, tracks: ClosedTracks, scenario: str, when: When, projector: Projector, streets: Streets
) -> pd.DataFrame:
    """Return a row for every event and each place that it has, event by event."""
    events = tracks.events()
    state = events.state
    # One column for each thing that may have happened: the beginning, K detections, D departures.
    step = np.concatenate([events.start_step[:, None], state.detection_step, state.first_step[:, :, OUT_OF_LANE]], 1)
    position_m = np.concatenate([state.start_m[:, None], state.detected_m, state.left_lane_m], axis=1)
    lane = np.concatenate([state.start_lane[:, None], state.detected_lane, state.departed_lane], axis=1)
    speed_mps = np.concatenate([state.start_mps[:, None], state.detected_mps, state.departed_mps], axis=1)
    what = [ATTACK_BEGAN, *[DETECTED] * len(study.detectors), *[LEFT_LANE] * len(study.defences)]
    by = ["", *study.detectors, *study.defence_names]
    event, column = np.nonzero(step >= 0)
    where_m = position_m[event, column]
    lon_lat = projector.to_lon_lat(where_m) if len(where_m) else where_m
    table: dict[str, Any] = {
        "scenario": np.full(len(event), scenario, object),
        "seed": np.full(len(event), when.seed),
        "vehicle_id": events.vehicle_id.astype(object)[event],
        "vehicle_type": events.vehicle_type.astype(object)[event],
        "profile": np.array(study.profiles, object)[events.profile[event]],
        "attack": np.array(study.plans, object)[events.plan[event]],
        "what": np.array(what, object)[column],
        "by": np.array(by, object)[column],
        "time_s": when.origin_s + step[event, column] * study.step_s,
        "x_m": where_m[:, 0],
        "y_m": where_m[:, 1],
        "lon_deg": lon_lat[:, 0],
        "lat_deg": lon_lat[:, 1],
        **streets.columns("", lane[event, column], speed_mps[event, column]),
    }
    return pd.DataFrame(table)
