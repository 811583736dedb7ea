"""Notes where attacks began, where they were seen, and where vehicles would have left their lane."""

from gpsec.core.kernels import inline
from gpsec.outcomes.state import OUT_OF_LANE, OutcomeState
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
    lane, speed_mps = vehicles.lane[v], vehicles.speed_mps[v]
    if tracks.start_step[row] == step:
        sums.start_m[row, 0], sums.start_m[row, 1] = x, y
        sums.start_lane[row], sums.start_mps[row] = lane, speed_mps
        sums.last_edge[row] = -1
    for k in range(sums.detection_step.shape[1]):
        if sums.detection_step[row, k] == step:
            sums.detected_m[row, k, 0], sums.detected_m[row, k, 1] = x, y
            sums.detected_lane[row, k], sums.detected_mps[row, k] = lane, speed_mps
    for d in range(sums.first_step.shape[1]):
        if sums.first_step[row, d, OUT_OF_LANE] == step:
            sums.left_lane_m[row, d, 0], sums.left_lane_m[row, d, 1] = x, y
            sums.departed_lane[row, d], sums.departed_mps[row, d] = lane, speed_mps
