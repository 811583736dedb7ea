"""Where the camera of a vehicle is, and how it is truly mounted."""

import numpy as np

from gpsec.imaging.pictures.camera import RoadCamera

# Behind the windscreen: so far ahead of the rear axle of a car, and behind the front of whatever is longer.
_AHEAD_M, _BEHIND_FRONT_M = 1.7, 1.9


def camera_on(axle_m: float) -> RoadCamera:
    """Return the camera of a vehicle whose front bumper is `axle_m` ahead of its rear axle."""
    return RoadCamera(x_m=max(_AHEAD_M, axle_m - _BEHIND_FRONT_M))


def misaligned(camera: RoadCamera, key: int, error_deg: float) -> RoadCamera:
    """Return the camera as it is mounted on the vehicle `key`, off by `error_deg` (σ) on each axis."""
    roll, pitch, yaw = np.random.default_rng([key, 11]).normal(0.0, error_deg, 3).tolist() if error_deg else (0.0,) * 3
    return camera.turned(roll, pitch, yaw)
