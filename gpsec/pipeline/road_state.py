"""What is kept of vehicle rows between steps of the closed loop, and what lies beside their paths."""

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.displaced import reached
from gpsec.steering.base import Follow
from gpsec.steering.steer import Steered
from gpsec.traffic.commands import Carried


class RoadState:
    """The lane of each vehicle's path, and whether it is a wreck or brakes.

    Attributes:
        path: (N,) lane of the path.
        wrecked, braking: (N,) the vehicle is a wreck; it brakes for another.
    """

    def __init__(self, sides: LaneSides) -> None:
        """Begin with nobody; `sides` is what lies beside all lanes."""
        self.path = np.zeros(1, np.int32)
        self.wrecked, self.braking = np.zeros(1, np.bool_), np.zeros(1, np.bool_)
        self._sides = sides
        self._left_hand = bool(sides.oncoming_right_m.sum() > sides.oncoming_left_m.sum())

    def enter(self, rows: Ints) -> None:
        """Begin anew in `rows`."""
        more = max(0, 2 * (int(rows.max()) + 1) - len(self.path))
        self.path = np.concatenate([self.path, np.zeros(more, np.int32)])
        self.wrecked = np.concatenate([self.wrecked, np.zeros(more, np.bool_)])
        self.braking = np.concatenate([self.braking, np.zeros(more, np.bool_)])
        self.path[rows], self.wrecked[rows], self.braking[rows] = 0, False, False

    def note(self, rows: Ints, lane: Ints, carried: Carried) -> None:
        """Take the paths of a step: of who is steered that which is held, of others their lane."""
        self.path[rows] = lane
        self.path[carried.rows] = carried.path

    def edge_m(self, rows: Ints, width_m: Floats) -> Floats:
        """Return (n,) where vehicles stop at the edge: half outside the outermost lane, or inside any other.

        Args:
            rows: (n,) vehicle rows.
            width_m: (n,) of their bodies.
        """
        sides, lane = self._sides, self.path[rows]
        beyond_m = sides.same_left_m[lane] if self._left_hand else sides.same_right_m[lane]
        inside_m = np.maximum(0.5 * (sides.width_m[lane] - width_m), 0.0)
        far_m = np.where(beyond_m > 0.0, inside_m, 0.5 * sides.width_m[lane])
        return far_m if self._left_hand else -far_m

    def reached(self, rows: Ints, width_m: Floats, steered: Steered) -> Flags:
        """Return (n, 4) which outcomes vehicles have truly reached; who stops at the edge on purpose reaches none."""
        meant = steered.driven[rows] & (steered.follow[rows] != Follow.EDGE)
        offset_m = np.where(meant, steered.offset_m[rows], 0.0)
        return reached(offset_m, width_m, self.path[rows], self._sides)
