"""Tails of the camera's noise, slopes that go with offsets, and lines that are none of the lane.

All of it is added to what `sense_rows` has made, by the same draws; only profiles that have some of it pay for it.
"""

from math import sqrt

from gpsec.core.arrays import Ints
from gpsec.core.kernels import kernel
from gpsec.core.noise import CAMERA_C0, CAMERA_C1, CAMERA_LINE, CAMERA_TAIL, normal, uniform
from gpsec.sensors.faults import CORE_FACTOR, LINE_BEGIN, LINE_END, LINE_M, SLOPE, TAIL_FACTOR, TAIL_SHARE
from gpsec.sensors.lane_view import fit_sigmas, view_length_m
from gpsec.sensors.state import SensorState
from gpsec.sensors.table import HALF_VIEW, RANGE, UNKNOWN, WHITE, ProfileTable
from gpsec.types.vehicles import Measurements, Vehicles


@kernel
def fault_lanes(
    rows: Ints, step: int, truth: Vehicles, table: ProfileTable, mind: SensorState, out: Measurements
) -> None:
    """Add the faults of this step to the lanes that are seen in it."""
    camera, faults = table.camera, table.faults
    for row in rows:
        key, p = truth.key[row], truth.profile[row]
        draw = uniform(key, CAMERA_LINE, step)
        if mind.wrong_line[row] != 0.0:
            if draw < faults[p, LINE_END]:
                mind.wrong_line[row] = 0.0
        elif draw < faults[p, LINE_BEGIN]:
            mind.wrong_line[row] = 1.0 if draw < 0.5 * faults[p, LINE_BEGIN] else -1.0
        if not out.camera_valid[row]:
            continue
        view = view_length_m(camera[p, RANGE], camera[p, HALF_VIEW], truth.camera_curvature_per_m[row])
        s0, s1, _, _ = fit_sigmas(camera[p, UNKNOWN] * camera[p, WHITE], camera[p, RANGE], view)
        n0, n1 = normal(key, CAMERA_C0, step), normal(key, CAMERA_C1, step)
        in_tail = uniform(key, CAMERA_TAIL, step) < faults[p, TAIL_SHARE]
        size = faults[p, TAIL_FACTOR] if in_tail else faults[p, CORE_FACTOR]
        slope = faults[p, SLOPE]
        out.lane_poly[row, 0] += (size - 1.0) * s0 * n0 + mind.wrong_line[row] * faults[p, LINE_M]
        out.lane_poly[row, 1] += s1 * (size * (slope * n0 + sqrt(1.0 - slope * slope) * n1) - n1)
