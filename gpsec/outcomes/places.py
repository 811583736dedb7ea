"""The table `places.csv`: where attacks began, where they were seen, where vehicles would have left their lane."""

from typing import Any

import numpy as np
import pandas as pd

from gpsec.core.geo import Projector
from gpsec.core.kernels import inline
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.state import OUT_OF_LANE, OutcomeState
from gpsec.outcomes.study import Study
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles

ATTACK_BEGAN, DETECTED, LEFT_LANE = "attack_began", "detected", "left_lane"


@inline
def note_places(row: int, step: int, tracks: Tracks, vehicles: Vehicles, sums: OutcomeState) -> None:
    """Note where a track under attack is, of which something is true for the first time in this step.

    Run it after the steps themselves have been noted.
    """
    if tracks.plan[row] == 0:
        return
    v = tracks.vehicle[row]
    x, y = vehicles.rear_m[v, 0], vehicles.rear_m[v, 1]
    if tracks.start_step[row] == step:
        sums.start_m[row, 0], sums.start_m[row, 1] = x, y
    for k in range(sums.detection_step.shape[1]):
        if sums.detection_step[row, k] == step:
            sums.detected_m[row, k, 0], sums.detected_m[row, k, 1] = x, y
    for d in range(sums.first_step.shape[1]):
        if sums.first_step[row, d, OUT_OF_LANE] == step:
            sums.left_lane_m[row, d, 0], sums.left_lane_m[row, d, 1] = x, y


def places_table(
    study: Study, tracks: ClosedTracks, scenario: str, seed: int, origin_s: float, projector: Projector
) -> pd.DataFrame:
    """Return a row for every event and each place that it has, event by event."""
    events = tracks.events()
    state = events.state
    # One column for each thing that may have happened: the beginning, K detections, D departures.
    step = np.concatenate([events.start_step[:, None], state.detection_step, state.first_step[:, :, OUT_OF_LANE]], 1)
    position_m = np.concatenate([state.start_m[:, None], state.detected_m, state.left_lane_m], axis=1)
    what = [ATTACK_BEGAN, *[DETECTED] * len(study.detectors), *[LEFT_LANE] * len(study.defences)]
    by = ["", *study.detectors, *study.defence_names]
    event, column = np.nonzero(step >= 0)
    where_m = position_m[event, column]
    lon_lat = projector.to_lon_lat(where_m) if len(where_m) else where_m
    table: dict[str, Any] = {
        "scenario": np.full(len(event), scenario, object),
        "seed": np.full(len(event), seed),
        "vehicle_id": events.vehicle_id.astype(object)[event],
        "profile": np.array(study.profiles, object)[events.profile[event]],
        "attack": np.array(study.plans, object)[events.plan[event]],
        "what": np.array(what, object)[column],
        "by": np.array(by, object)[column],
        "time_s": origin_s + step[event, column] * study.step_s,
        "x_m": where_m[:, 0],
        "y_m": where_m[:, 1],
        "lon_deg": lon_lat[:, 0],
        "lat_deg": lon_lat[:, 1],
    }
    return pd.DataFrame(table)
