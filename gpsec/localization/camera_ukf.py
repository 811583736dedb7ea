"""The paper's mitigation: a UKF of odometry, camera and HD map while GNSS is isolated."""

from typing import ClassVar

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.hdmap.arrays import MapArrays, MatchIndex
from gpsec.localization import ukf
from gpsec.localization.responses import Cells, Response, World
from gpsec.localization.state import FilterState
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class CameraUkf(Response):
    """The lane offset seen by the camera corrects the propagated position (Eqs 11-16)."""

    name: ClassVar[str] = "ukf"

    def __init__(self) -> None:
        self._weights = ukf.sigma_weights()

    def correct(
        self, cells: Cells, filters: FilterState, tracks: Tracks, vehicles: Vehicles, seen: Measurements, world: World
    ) -> None:
        """Run Eqs 13-16 in every cell whose camera sees the lane."""
        _correct(
            cells.row,
            cells.defence,
            filters.mean,
            filters.covariance,
            filters.segment,
            filters.repairs,
            self._weights,
            np.empty(ukf.NEAR, np.int32),
            world.view.lanes,
            world.view.lookup,
            world.view.mode,
            world.view.layer,
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
    weights: ukf.SigmaWeights,
    near: Ints,
    lanes: MapArrays,
    index: MatchIndex,
    mode: int,
    layer: Ints,
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
        segment[r, d], repaired = ukf.update(
            mean[r, d],
            covariance[r, d],
            weights,
            lanes,
            index,
            mode,
            layer[profile[v]],
            lane[v],
            segment[r, d],
            -lane_poly[v, 0],
            camera_sigma_m[v],
            near,
        )
        repairs[r, d] += repaired
