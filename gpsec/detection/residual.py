"""The residual z = d_camera - d_map(fix) of every track, ten times a second."""

from dataclasses import dataclass
from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.core.threads import Threads
from gpsec.detection.pairing import (
    DetectionClock,
    Motion,
    Samples,
    Sampling,
    Waiting,
    grow_older,
    keep_fix,
    keep_lane,
    take_pair,
)
from gpsec.hdmap.arrays import MapArrays, MatchIndex
from gpsec.hdmap.matching import offset_on
from gpsec.hdmap.search import MIN_COS, TRACKED, match
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class MapView(NamedTuple):
    """The HD map as vehicles see it.

    Attributes:
        lanes, lookup: the map.
        mode: how to match.
        layer: (P,) the layer of each profile.
    """

    lanes: MapArrays
    lookup: MatchIndex
    mode: int
    layer: Ints


class Seen(NamedTuple):
    """What is given in a step: fields of `Tracks`, `Vehicles` and `Measurements`."""

    vehicle: Ints
    fix_m: Floats
    fix_valid: Flags
    profile: Ints
    lane: Ints
    lane_poly: Floats
    camera_valid: Flags
    camera_sigma_m: Floats


class Formed(NamedTuple):
    """What is found: fields of `Tracks`."""

    segment: Ints
    residual_m: Floats
    residual_valid: Flags
    paired_m: Floats


@kernel
def lateral_residual(
    rows: Ints,
    ticks: bool,
    view: MapView,
    sampling: Sampling,
    waiting: Waiting,
    seen: Seen,
    motion: Motion,
    formed: Formed,
) -> None:
    """Take in the samples of a step and set z = d_camera - d_map of the track rows `rows` that are due.

    d_camera = -C0 (Eq 1) and d_map = d1 of the fix on the vehicle's own map (Eqs 2-6).
    """
    for row in rows:
        v = seen.vehicle[row]
        p = seen.profile[v]
        formed.residual_m[row] = 0.0
        formed.residual_valid[row] = False
        if ticks:
            waiting.due[row] = True
        grow_older(waiting, row, sampling, p, motion, v)
        if seen.fix_valid[row]:
            keep_fix(waiting, row, seen.fix_m[row, 0], seen.fix_m[row, 1])
        if seen.camera_valid[v]:
            poly = seen.lane_poly[v]
            sigma = seen.camera_sigma_m[v]
            keep_lane(waiting, row, seen.lane[v], motion.heading_rad[v], -poly[0], 2.0 * poly[2], sigma)
        if not take_pair(waiting, row):
            continue
        formed.paired_m[row, 0] = waiting.fix_m[row, 0] + waiting.since_fix_m[row, 0]
        formed.paired_m[row, 1] = waiting.fix_m[row, 1] + waiting.since_fix_m[row, 1]
        x = waiting.fix_m[row, 0] + (waiting.since_fix_m[row, 0] - waiting.since_camera_m[row, 0])
        y = waiting.fix_m[row, 1] + (waiting.since_fix_m[row, 1] - waiting.since_camera_m[row, 1])
        heading = waiting.heading_rad[row]
        layer = view.layer[p]
        here = match(view.lanes, view.lookup, view.mode, layer, waiting.lane[row], x, y, heading, formed.segment[row])
        formed.segment[row] = here
        if here < 0:
            continue
        offset, cosine = offset_on(view.lanes, here, x, y, heading, view.mode == TRACKED)
        if abs(cosine) < MIN_COS:
            continue
        formed.residual_m[row] = waiting.offset_m[row] - offset
        formed.residual_valid[row] = True


@dataclass(frozen=True)
class Residuals:
    """Forms the residuals of a run; what waits for its counterpart is in `Samples`.

    Attributes:
        view: the map.
        sampling: how old samples may be.
    """

    view: MapView
    sampling: Sampling

    def update(
        self,
        step: int,
        samples: Samples,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
    ) -> None:
        """Take step number `step` (from 0) of the track rows `rows`; sets residuals and paired fixes of `tracks`."""
        threads.run(
            lateral_residual,
            rows,
            DetectionClock(self.sampling.step_s).ticks(step),
            self.view,
            self.sampling,
            samples.arrays(),
            Seen(
                tracks.vehicle,
                tracks.fix_m,
                tracks.fix_valid,
                vehicles.profile,
                vehicles.lane,
                seen.lane_poly,
                seen.camera_valid,
                seen.camera_sigma_m,
            ),
            Motion(seen.speed_mps, seen.yaw_rate_rps, seen.heading_rad),
            Formed(tracks.segment, tracks.residual_m, tracks.residual_valid, tracks.paired_m),
        )
