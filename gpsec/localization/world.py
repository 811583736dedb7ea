"""What a filter works with: sensor figures and map, what the camera sees, and room for intermediate results."""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.filters.noise import FilterNoise
from gpsec.hdmap.arrays import MapView

# Segments that one search may find for all sigma points; where there are more, each point is searched for.
NEAR = 64


class World(NamedTuple):
    """What filters work with in every step.

    Attributes:
        hd_map: as vehicles see it.
        noise: sensor figures of the profiles.
        step_s: length of a step.
    """

    hd_map: MapView
    noise: FilterNoise[Floats]
    step_s: float


class LaneSight(NamedTuple):
    """What the camera of one vehicle sees.

    Attributes:
        lane: that it is believed to show.
        offset_m: -C0, where the vehicle is in its lane, left positive.
        slope: C1, the direction of the lane in the vehicle's frame.
        sigma_m: standard deviation that the camera states for C0.
        speed_mps, yaw_rate_rps: of the vehicle, by odometer and gyro.
    """

    lane: int
    offset_m: float
    slope: float
    sigma_m: float
    speed_mps: float
    yaw_rate_rps: float


class Room(NamedTuple):
    """Room to work in, since kernels cannot allocate, for a filter of S states.

    Attributes:
        root: (S, S) for a root of the covariance.
        expected: (2S + 1, 2) for what sigma points expect to see.
        near: (NEAR,) for segments near them.
    """

    root: Floats
    expected: Floats
    near: Ints


def make_room(states: int) -> Room:
    """Return room for one thread."""
    return Room(np.empty((states, states)), np.empty((2 * states + 1, 2)), np.empty(NEAR, np.int32))
