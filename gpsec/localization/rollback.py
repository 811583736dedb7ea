"""The paper's UKF, restarted from before the attack could have been absorbed."""

from typing import ClassVar

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.hdmap.arrays import MapArrays, MatchIndex
from gpsec.localization import ukf
from gpsec.localization.camera_ukf import CameraUkf
from gpsec.localization.history import History, Recall, entry, keep, restore
from gpsec.localization.noise import FilterNoise
from gpsec.localization.responses import Cells, World
from gpsec.localization.state import FilterArrays, FilterState
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles


class Rollback(CameraUkf):
    """On an alarm the filter restarts from before it; then it is the paper's UKF."""

    name: ClassVar[str] = "rollback"
    rolls_back: ClassVar[bool] = True

    def rewind(
        self,
        cells: Cells,
        filters: FilterState,
        history: History,
        tracks: Tracks,
        vehicles: Vehicles,
        world: World,
        recall: Recall,
    ) -> None:
        """Go back and come again with the stored odometry and camera, without GNSS."""
        _rewind(
            cells.row,
            cells.defence,
            filters.arrays(),
            history,
            recall,
            self._weights,
            np.empty(ukf.NEAR, np.int32),
            world.view.lanes,
            world.view.lookup,
            world.view.mode,
            world.view.layer,
            world.noise,
            world.step_s,
            tracks.vehicle,
            vehicles.profile,
        )


@kernel
def _rewind(
    row: Ints,
    defence: Ints,
    filters: FilterArrays,
    history: History,
    recall: Recall,
    weights: ukf.SigmaWeights,
    near: Ints,
    lanes: MapArrays,
    index: MatchIndex,
    mode: int,
    layer: Ints,
    table: FilterNoise[Floats],
    step_s: float,
    vehicle: Ints,
    profile: Ints,
) -> None:
    for i in range(len(row)):
        r = row[i]
        d = defence[i]
        v = vehicle[r]
        q = profile[v]
        mean = filters.mean[r, d]
        covariance = filters.covariance[r, d]
        last = filters.steps[r] - 1
        first, isolated = restore(filters, r, d, recall)
        for step in range(first, last + 1):
            at = entry(history, v, last - step)
            speed_mps = history.motion[v, at, 0]
            yaw_rate_rps = history.motion[v, at, 1]
            if step > first:
                # What was kept since then may be spoofed.
                keep(filters, r, d, step, recall.interval, True)
            elif not isolated:
                heading = history.motion[v, at, 2] - yaw_rate_rps * step_s
                ukf.drop_polluted_yaw(mean, covariance, heading, table.heading_rad[q])
            ukf.predict(mean, covariance, table, q, speed_mps, yaw_rate_rps, step_s)
            filters.isolated_way_m[r, d] += abs(speed_mps) * step_s
            if step == last or history.lane[v, at] < 0:
                continue
            filters.segment[r, d], repaired = ukf.update(
                mean,
                covariance,
                weights,
                lanes,
                index,
                mode,
                layer[q],
                history.lane[v, at],
                filters.segment[r, d],
                -history.camera[v, at, 0],
                history.camera[v, at, 2],
                near,
            )
            filters.repairs[r, d] += repaired
