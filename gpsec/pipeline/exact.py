"""What sensors without errors would say: how an attacker who follows a vehicle sees it from outside."""

from gpsec.core.arrays import Ints
from gpsec.core.geo import wrap_angle
from gpsec.core.kernels import kernel
from gpsec.sensors.lane_view import lane_polynomial
from gpsec.types.vehicles import Measurements, Vehicles


@kernel
def sense_exactly(rows: Ints, vehicles: Vehicles, seen: Measurements, exact: Measurements) -> None:
    """Fill `exact` for vehicle rows: samples come when they do come in `seen`, and hold the truth."""
    for row in rows:
        exact.fix_m[row, 0], exact.fix_m[row, 1] = vehicles.rear_m[row, 0], vehicles.rear_m[row, 1]
        exact.fix_valid[row] = seen.fix_valid[row]
        exact.speed_mps[row] = vehicles.speed_mps[row]
        exact.yaw_rate_rps[row] = vehicles.yaw_rate_rps[row]
        exact.heading_rad[row] = vehicles.yaw_rad[row]
        exact.camera_valid[row] = seen.camera_valid[row]
        exact.camera_sigma_m[row] = seen.camera_sigma_m[row]
        if seen.camera_valid[row]:
            turn = wrap_angle(vehicles.camera_yaw_rad[row] - vehicles.yaw_rad[row])
            offset, curvature = vehicles.camera_offset_m[row], vehicles.camera_curvature_per_m[row]
            c0, c1, c2, c3 = lane_polynomial(offset, turn, curvature)
            exact.lane_poly[row, 0], exact.lane_poly[row, 1] = c0, c1
            exact.lane_poly[row, 2], exact.lane_poly[row, 3] = c2, c3
