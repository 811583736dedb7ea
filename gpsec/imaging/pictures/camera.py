"""Where a point of the road appears in a picture: intrinsics, lens distortion and how the camera is mounted."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, radians, sin
from typing import Self

import numpy as np

from gpsec.core.arrays import Floats

# Rounds of the fixed-point iteration that takes the distortion of a lens out again; each gains about a digit.
_ROUNDS = 8


@dataclass(frozen=True)
class RoadCamera:
    """A calibrated camera on a vehicle; frame of the vehicle: rear axle on the road, x forward, y left, z up.

    Attributes:
        width, height: of its pictures, pixels.
        fx, fy, cx, cy: focal lengths and principal point, pixels; u to the right, v down, of pixels' centres.
        distortion: k1, k2, p1, p2, k3 of the radial and tangential model (Brown 1966).
        x_m, y_m, z_m: of the camera.
        roll_deg, pitch_deg, yaw_deg: right side down, looking down, and looking left are positive.
        hood_row: first row in which the vehicle's own hood is seen; `height` where there is none.
    """

    width: int = 640
    height: int = 360
    fx: float = 656.0
    fy: float = 656.0
    cx: float = 319.5
    cy: float = 179.5
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    x_m: float = 1.7
    y_m: float = 0.0
    z_m: float = 1.3
    roll_deg: float = 0.0
    pitch_deg: float = 3.5
    yaw_deg: float = 0.0
    hood_row: int = 360

    @cached_property
    def axes(self) -> Floats:
        """The camera's right, down and forward, (3, 3), one a row, in the frame of the vehicle."""
        roll, pitch, yaw = map(radians, (self.roll_deg, self.pitch_deg, self.yaw_deg))
        forward = np.array([cos(pitch) * cos(yaw), cos(pitch) * sin(yaw), -sin(pitch)])
        level = np.array([sin(yaw), -cos(yaw), 0.0])
        below = np.cross(forward, level)
        return np.stack([cos(roll) * level + sin(roll) * below, cos(roll) * below - sin(roll) * level, forward])

    def turned(self, roll_deg: float, pitch_deg: float, yaw_deg: float) -> Self:
        """Return the camera turned by so much from how it is mounted."""
        return replace(
            self,
            roll_deg=self.roll_deg + roll_deg,
            pitch_deg=self.pitch_deg + pitch_deg,
            yaw_deg=self.yaw_deg + yaw_deg,
        )

    def scaled(self, width: int) -> Self:
        """Return the camera of the same pictures, resized to `width`."""
        ratio = width / self.width
        height = round(self.height * ratio)
        down = height / self.height
        return replace(
            self,
            width=width,
            height=height,
            fx=self.fx * ratio,
            fy=self.fy * down,
            cx=(self.cx + 0.5) * ratio - 0.5,
            cy=(self.cy + 0.5) * down - 0.5,
            hood_row=round(self.hood_row * down),
        )

    def project(self, points_m: Floats) -> tuple[Floats, Floats]:
        """Return where (n, 3) points appear, (n, 2) pixels, and how far ahead of the camera they are, (n,).

        Those that are not ahead appear nowhere: what is returned for them means nothing.
        """
        seen = (points_m - np.array([self.x_m, self.y_m, self.z_m])) @ self.axes.T
        depth = seen[:, 2]
        ahead = np.maximum(depth, 1e-6)
        x, y = self._distorted(seen[:, 0] / ahead, seen[:, 1] / ahead)
        return np.stack([self.fx * x + self.cx, self.fy * y + self.cy], axis=1), depth

    def on_road(self, pixels: Floats) -> Floats:
        """Return the points of a flat road, (n, 2), that appear at (n, 2) pixels; infinite at and over the horizon."""
        rays = np.ones((len(pixels), 3))
        rays[:, 0], rays[:, 1] = self._ideal((pixels[:, 0] - self.cx) / self.fx, (pixels[:, 1] - self.cy) / self.fy)
        rays = rays @ self.axes
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where(rays[:, 2] < -1e-9, -self.z_m / rays[:, 2], np.inf)
            found: Floats = np.array([self.x_m, self.y_m]) + reach[:, None] * rays[:, :2]
        found[~np.isfinite(reach)] = np.inf
        return found

    def _distorted(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        k1, k2, p1, p2, k3 = self.distortion
        if not any(self.distortion):
            return x, y
        r2 = np.minimum(x * x + y * y, 4.0)  # the series means nothing far outside of the picture
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return (
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        )

    def _ideal(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Take the distortion out, by fixed-point iteration."""
        u, v = x, y
        for _ in range(_ROUNDS if any(self.distortion) else 0):
            du, dv = self._distorted(u, v)
            u, v = u + x - du, v + y - dv
        return u, v
