"""The residual z = d_camera - d_map(fix) of every track, ten times a second."""

from dataclasses import dataclass

from gpsec.core.arrays import Ints
from gpsec.core.kernels import kernel
from gpsec.core.threads import Threads
from gpsec.detection.pairing import DetectionClock, Pending, Sampling, grow_older, keep_fix, keep_lane, take_pair
from gpsec.hdmap.arrays import MapView, Pose
from gpsec.hdmap.matching import offset_on
from gpsec.hdmap.search import MIN_COS, NEAREST, TRACKED, match
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


@kernel
def lateral_residual(
    rows: Ints,
    ticks: bool,
    view: MapView,
    sampling: Sampling,
    pending: Pending,
    tracks: Tracks,
    vehicles: Vehicles,
    seen: Measurements,
) -> None:
    """Take in the samples of a step and set z = d_camera - d_map of the track rows `rows` that are due.

    d_camera = -C0 (Eq 1) and d_map = d1 of the fix on the vehicle's own map (Eqs 2-6), from the lane that the vehicle
    believes to be on. A fix that nothing matches leaves `Tracks.unmatched`.
    """
    for row in rows:
        v = tracks.vehicle[row]
        p = vehicles.profile[v]
        pending.elapsed_steps[row] = 1 if pending.formed[row] else pending.elapsed_steps[row] + 1
        pending.formed[row] = False
        tracks.residual_m[row] = 0.0
        tracks.residual_valid[row] = False
        if ticks:
            pending.due[row] = True
        grow_older(pending, row, sampling, p, seen, v)
        if tracks.fix_valid[row]:
            keep_fix(pending, row, tracks.fix_m[row, 0], tracks.fix_m[row, 1])
        if seen.camera_valid[v] and tracks.lane_known[row]:
            poly = seen.lane_poly[v]
            sigma = seen.camera_sigma_m[v]
            keep_lane(pending, row, tracks.lane[row], seen.heading_rad[v], -poly[0], 2.0 * poly[2], sigma)
        if not take_pair(pending, row):
            continue
        tracks.paired_m[row, 0] = pending.fix_m[row, 0] + pending.since_fix_m[row, 0]
        tracks.paired_m[row, 1] = pending.fix_m[row, 1] + pending.since_fix_m[row, 1]
        x = pending.fix_m[row, 0] + (pending.since_fix_m[row, 0] - pending.since_camera_m[row, 0])
        y = pending.fix_m[row, 1] + (pending.since_fix_m[row, 1] - pending.since_camera_m[row, 1])
        heading = pending.heading_rad[row]
        pose = Pose(view.layer[p], pending.lane[row], x, y, heading)
        here = match(view.lanes, view.lookup, view.mode, pose, tracks.segment[row])
        tracks.segment[row] = here
        if here < 0:
            tracks.unmatched[row] = True
            continue
        offset, cosine = offset_on(view.lanes, here, x, y, heading, view.mode == TRACKED)
        if abs(cosine) < MIN_COS:
            tracks.unmatched[row] = True
            continue
        if view.mode == NEAREST:
            tracks.lane[row] = view.lanes.lane[here]
        tracks.residual_m[row] = pending.offset_m[row] - offset
        tracks.residual_valid[row] = True
        pending.formed[row] = True


@dataclass(frozen=True)
class Residuals:
    """Forms the residuals of a run; what waits for its counterpart is in `Pending`.

    Attributes:
        view: the map.
        sampling: how old samples may be.
    """

    view: MapView
    sampling: Sampling

    def update(
        self,
        step: int,
        pending: Pending,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
    ) -> None:
        """Take step number `step` (from 0) of the track rows `rows`; sets residuals and paired fixes of `tracks`."""
        ticks = DetectionClock(self.sampling.step_s).ticks(step)
        threads.run(lateral_residual, rows, ticks, self.view, self.sampling, pending, tracks, vehicles, seen)
