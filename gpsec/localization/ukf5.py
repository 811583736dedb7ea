"""A UKF that knows its odometer and its gyro, and sees the direction of the lane as well."""

from typing import ClassVar

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.hdmap.arrays import MapArrays, MatchIndex
from gpsec.localization import lane_ukf
from gpsec.localization.noise import FilterNoise
from gpsec.localization.responses import Cells, Response, World
from gpsec.localization.state import FilterState
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class Ukf5(Response):
    """Odometer scale and gyro bias, learnt with GNSS, and lane offset and direction correct the estimate."""

    name: ClassVar[str] = "ukf5"
    learns: ClassVar[bool] = True

    def correct(
        self, cells: Cells, filters: FilterState, tracks: Tracks, vehicles: Vehicles, seen: Measurements, world: World
    ) -> None:
        """Correct every cell whose camera sees the lane."""
        _correct(
            cells.row,
            cells.defence,
            filters.mean,
            filters.covariance,
            filters.segment,
            filters.repairs,
            lane_ukf.room(),
            world.view.lanes,
            world.view.lookup,
            world.view.mode,
            world.view.layer,
            world.noise,
            tracks.vehicle,
            vehicles.profile,
            vehicles.lane,
            seen.lane_poly,
            seen.camera_valid,
            seen.camera_sigma_m,
        )


@kernel
def _correct(
    row: Ints,
    defence: Ints,
    mean: Floats,
    covariance: Floats,
    segment: Ints,
    repairs: Ints,
    room: lane_ukf.Room,
    lanes: MapArrays,
    index: MatchIndex,
    mode: int,
    layer: Ints,
    table: FilterNoise[Floats],
    vehicle: Ints,
    profile: Ints,
    lane: Ints,
    lane_poly: Floats,
    camera_valid: Flags,
    camera_sigma_m: Floats,
) -> None:
    for i in range(len(row)):
        r = row[i]
        d = defence[i]
        v = vehicle[r]
        if not camera_valid[v]:
            continue
        q = profile[v]
        offset_sigma_m, slope_sigma = lane_ukf.camera_noise(table, q, camera_sigma_m[v])
        segment[r, d], repaired = lane_ukf.update(
            mean[r, d],
            covariance[r, d],
            room,
            lanes,
            index,
            mode,
            layer[q],
            lane[v],
            segment[r, d],
            -lane_poly[v, 0],
            lane_poly[v, 1],
            offset_sigma_m,
            slope_sigma,
        )
        repairs[r, d] += repaired
