"""The loops over branches, written once: a filter is a few small functions, and kernels are made of these.

All functions of a filter are compiled by `gpsec.core.kernels.inline` and take slices of one branch: `mean` (S,) and
`covariance` (S, S) are changed in place. The first three states are east, north and yaw.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from gpsec.core.arrays import Floats, Ints
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import inline, kernel
from gpsec.filters.noise import FilterNoise
from gpsec.localization.history import Recall, Recorded, entry, keep_snapshot, restore
from gpsec.localization.state import Branches, Cells
from gpsec.localization.world import LaneSight, Room, World
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# A yaw that is further from the heading sensor's, in standard deviations of that, has been turned by fixes.
YAW_SIGMAS = 4.0

# Corrects a filter with what the camera sees: (mean, covariance, hint, room, world, profile, sight) -> the segment of
# the map that the mean was matched to (`hint` is that of the last time, -1 for none), and repairs of the covariance.
Correction = Callable[[Floats, Floats, int, Room, World, int, LaneSight], tuple[int, int]]
BranchLoop = Callable[..., None]


@dataclass(frozen=True)
class Filter:
    """A filter with GNSS and without.

    Attributes:
        states: their number S.
        start: (mean, covariance, noise, profile, x_m, y_m, heading_rad) begins at the first fix.
        predict: (mean, covariance, noise, profile, speed_mps, yaw_rate_rps, step_s, isolated) takes one step.
        update: (mean, covariance, innovation, x_m, y_m, white_m) corrects with a fix, sets the (2,) normalised
            innovations and returns how often it had to repair the covariance.
        isolate: (mean, covariance, noise, profile) gives GNSS up.
        take_yaw: (mean, covariance, heading_rad, sigma_rad) takes the yaw of the heading sensor.
        drift: (noise, profile, way_m) -> variance along the way that `way_m` of isolation have added, as far as it is
            not in the covariance.
        trust: (mean, covariance, noise, profile) takes GNSS back.
    """

    states: int
    start: Callable[..., None]
    predict: Callable[..., None]
    update: Callable[..., int]
    isolate: Callable[..., None]
    take_yaw: Callable[..., None]
    drift: Callable[..., float]
    trust: Callable[..., None]


@cache
def isolating(filter_: Filter) -> Callable[..., None]:
    """Return what a filter does when isolation begins."""
    isolate, take_yaw = filter_.isolate, filter_.take_yaw

    @inline
    def begin(
        mean: Floats, covariance: Floats, noise: FilterNoise[Floats], profile: int, heading_rad: float, lost: bool
    ) -> None:
        """Give GNSS up; take the heading sensor's yaw where the filter's contradicts it.

        Fixes that jump sideways turn the EKF's yaw (a jump of 2.4 m by some degrees), and in isolation nothing would
        correct it. The heading sensor knows nothing of fixes. Where fixes are only lost, the filter knows yaw better
        than a sensor that may be off by its bias.
        """
        isolate(mean, covariance, noise, profile)
        sigma_rad = noise.heading_rad[profile]
        if not lost and abs(wrap_angle(mean[2] - heading_rad)) > YAW_SIGMAS * sigma_rad:
            take_yaw(mean, covariance, heading_rad, sigma_rad)

    return begin


@cache
def advancing(filter_: Filter) -> BranchLoop:
    """Return the kernel that moves branches on by one step, and corrects those that trust GNSS."""
    start, predict, update, begin = filter_.start, filter_.predict, filter_.update, isolating(filter_)

    @kernel
    def advance(
        rows: Ints,
        branches: Branches,
        cells: Cells,
        tracks: Tracks,
        profile: Ints,
        seen: Measurements,
        noise: FilterNoise[Floats],
        recall: Recall,
    ) -> None:
        step_s = recall.step_s
        for row in rows:
            track = branches.track[row]
            v = tracks.vehicle[track]
            q = profile[v]
            mean = branches.mean[row]
            covariance = branches.covariance[row]
            x = tracks.fix_m[track, 0]
            y = tracks.fix_m[track, 1]
            if branches.steps[row] < 0:
                if tracks.fix_valid[track]:
                    branches.steps[row] = 0
                    start(mean, covariance, noise, q, x, y, seen.heading_rad[v])
                continue
            isolated = branches.response[row] >= 0
            entered = branches.entered[row]
            if branches.past_isolated.shape[1] > 0:
                keep_snapshot(branches, row, branches.steps[row], recall.interval, isolated and not entered)
            branches.steps[row] += 1
            if entered:
                branches.consistent_s[row] = 0.0
                branches.isolated_way_m[row] = 0.0
                branches.segment[row] = -1
                # The filter has not turned yet in this step.
                heading = seen.heading_rad[v] - seen.yaw_rate_rps[v] * step_s
                begin(mean, covariance, noise, q, heading, cells.lost[track])
            branches.innovation_valid[row] = False
            predict(mean, covariance, noise, q, seen.speed_mps[v], seen.yaw_rate_rps[v], step_s, isolated)
            if isolated:
                branches.isolated_way_m[row] += abs(seen.speed_mps[v]) * step_s
            elif tracks.fix_valid[track]:
                white_m = noise.gnss_white_m[q]
                branches.repairs[row] += update(mean, covariance, branches.innovation[row], x, y, white_m)
                branches.innovation_valid[row] = True

    return advance


@cache
def correcting(correction: Correction) -> BranchLoop:
    """Return the kernel that corrects isolated branches whose camera sees the lane."""

    @kernel
    def correct(
        rows: Ints,
        branches: Branches,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        world: World,
        room: Room,
    ) -> None:
        for row in rows:
            track = branches.track[row]
            v = tracks.vehicle[track]
            if not (seen.camera_valid[v] and tracks.lane_known[track]):
                continue
            sight = LaneSight(
                tracks.lane[track],
                -seen.lane_poly[v, 0],
                seen.lane_poly[v, 1],
                seen.camera_sigma_m[v],
                seen.speed_mps[v],
                seen.yaw_rate_rps[v],
            )
            branches.segment[row], repaired = correction(
                branches.mean[row],
                branches.covariance[row],
                branches.segment[row],
                room,
                world,
                vehicles.profile[v],
                sight,
            )
            branches.repairs[row] += repaired

    return correct


@inline
def no_correction(
    mean: Floats, covariance: Floats, hint: int, room: Room, world: World, profile: int, sight: LaneSight
) -> tuple[int, int]:
    """Correct nothing."""
    return hint, 0


@cache
def rewinding(filter_: Filter, correction: Correction) -> BranchLoop:
    """Return the kernel that makes branches what they were, and brings them up to now without GNSS.

    The motion of the last step is applied, its camera is not.
    """
    predict, begin = filter_.predict, isolating(filter_)

    @kernel
    def rewind(
        rows: Ints,
        branches: Branches,
        tracks: Tracks,
        vehicles: Vehicles,
        recorded: Recorded,
        world: World,
        recall: Recall,
        room: Room,
    ) -> None:
        noise, step_s, history = world.noise, world.step_s, recorded.history
        for row in rows:
            track = branches.track[row]
            v = tracks.vehicle[track]
            q = vehicles.profile[v]
            mean = branches.mean[row]
            covariance = branches.covariance[row]
            last = branches.steps[row] - 1
            first, isolated = restore(branches, row, recall)
            for step in range(first, last + 1):
                at = entry(history, v, last - step)
                speed_mps = history.motion[v, at, 0]
                yaw_rate_rps = history.motion[v, at, 1]
                if step > first:
                    # What was kept since then may be spoofed.
                    keep_snapshot(branches, row, step, recall.interval, True)
                elif not isolated:
                    heading = history.motion[v, at, 2] - yaw_rate_rps * step_s
                    begin(mean, covariance, noise, q, heading, False)
                predict(mean, covariance, noise, q, speed_mps, yaw_rate_rps, step_s, True)
                branches.isolated_way_m[row] += abs(speed_mps) * step_s
                if step == last or recorded.lane[track, at] < 0:
                    continue
                camera = history.camera[v, at]
                lane = recorded.lane[track, at]
                sight = LaneSight(lane, -camera[0], camera[1], camera[2], speed_mps, yaw_rate_rps)
                branches.segment[row], repaired = correction(
                    mean, covariance, branches.segment[row], room, world, q, sight
                )
                branches.repairs[row] += repaired

    return rewind
