"""What the receivers of a run have around them: the error that they share, and multipath by place."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.noise import (
    COMMON_BIAS_EAST,
    COMMON_BIAS_NORTH,
    GNSS_OFFSET_EAST,
    GNSS_OFFSET_NORTH,
    GNSS_WANDER_EAST,
    GNSS_WANDER_NORTH,
    plain_normal,
    vehicle_key,
)
from gpsec.core.tables import Table, blank
from gpsec.sensors.canyons import CANYON_SCALE, add_multipath
from gpsec.sensors.multipath import Places
from gpsec.sensors.sense import Sensors
from gpsec.sensors.smooth import GAIN, HOLD_DECAY, RATE, RATE_DECAY, RATE_KICK, REACH, TOGETHER
from gpsec.sensors.table import BIAS, DECAY, KICK
from gpsec.types.vehicles import Measurements, Vehicles


class CommonError(NamedTuple):
    """The slow error that all receivers of a profile share; a row is a profile.

    Attributes:
        begun: (P,) it has been drawn.
        bias_m: (P, 2) east and north.
        wander_mps, wander_m: (P, 2) rate of the smooth wander, and where it has led to.
    """

    begun: Flags = blank(False)
    bias_m: Floats = blank(0.0, 2)
    wander_mps: Floats = blank(0.0, 2)
    wander_m: Floats = blank(0.0, 2)


@dataclass(frozen=True)
class SharedErrors:
    """What is added to the fixes of all vehicles.

    Attributes:
        sensors: of the run; they say which share of the slow error is common.
        seed: of the run.
        places: of multipath, beside that of the profiles.
    """

    sensors: Sensors
    seed: int
    places: Sequence[Places] = ()

    @property
    def is_quiet(self) -> bool:
        """Whether nothing is added."""
        return not self.places and not self._has_common and not self._has_multipath

    @cached_property
    def _has_common(self) -> bool:
        return bool((self.sensors.common_shares > 0.0).any())

    @cached_property
    def _has_multipath(self) -> bool:
        return bool((self.sensors.table.multipath[:, CANYON_SCALE] > 0.0).any())

    def new_state(self) -> Table[CommonError]:
        """Return the state of the common error."""
        return Table(CommonError, len(self.sensors.profiles))

    def disturb(
        self, state: CommonError, rows: Ints, step: int, vehicles: Vehicles, measurements: Measurements
    ) -> None:
        """Add to the fixes of this step of the vehicle `rows`; to be called once in every step of the run.

        The common error depends on the seed and the step alone, and has the standard deviation and correlation time of
        each profile; profiles are driven by the same draws.
        """
        if self._has_common:
            self._advance(state, step)
        fresh = rows[measurements.fix_valid[rows]]
        if not len(fresh):
            return
        fix_m, true_m = measurements.fix_m, vehicles.rear_m[fresh]
        if self._has_common:
            fix_m[fresh] += (state.bias_m + state.wander_m)[vehicles.profile[fresh]]
        if self._has_multipath:
            add_multipath(fresh, self._canyons, self.sensors.table.multipath, vehicles, measurements)
        for place in self.places:
            fix_m[fresh] += place.error_m(true_m)

    @cached_property
    def _canyons(self) -> np.uint64:
        return np.uint64(vehicle_key(self.seed, "multipath of profiles"))

    def _advance(self, state: CommonError, step: int) -> None:
        key = vehicle_key(self.seed, "all vehicles")
        draws = plain_normal(key, COMMON_BIAS_EAST, step), plain_normal(key, COMMON_BIAS_NORTH, step)
        parts = self.sensors.mismatch.gnss_slow * np.sqrt(self.sensors.common_shares)
        self._advance_wander(state, key, step, parts)
        for profile, (gnss, part) in enumerate(zip(self.sensors.stated.gnss, parts.tolist(), strict=True)):
            decay, sigma = (gnss[DECAY], gnss[KICK]) if state.begun[profile] else (0.0, gnss[BIAS])
            for axis, draw in enumerate(draws):
                state.bias_m[profile, axis] = decay * state.bias_m[profile, axis] + part * sigma * draw
        state.begun[:] = True

    def _advance_wander(self, state: CommonError, key: int, step: int, parts: Floats) -> None:
        """Let the common wander go on by a step, as `gpsec.sensors.wander` does with each vehicle's own."""
        wander = self.sensors.stated.wander
        if not wander[:, RATE].any():
            return
        kicks = [plain_normal(key, channel, step) for channel in (GNSS_WANDER_EAST, GNSS_WANDER_NORTH)]
        others = [plain_normal(key, channel, step) for channel in (GNSS_OFFSET_EAST, GNSS_OFFSET_NORTH)]
        for axis, (kick, other) in enumerate(zip(kicks, others, strict=True)):
            before = state.wander_mps[:, axis]
            fresh = ~state.begun
            rate = np.where(fresh, wander[:, RATE], wander[:, RATE_KICK]) * parts * kick
            rate += np.where(fresh, 0.0, wander[:, RATE_DECAY] * before)
            together = wander[:, TOGETHER]
            begins = parts * wander[:, REACH] * (together * kick + np.sqrt(1.0 - together**2) * other)
            goes_on = wander[:, HOLD_DECAY] * state.wander_m[:, axis] + 0.5 * wander[:, GAIN] * (before + rate)
            state.wander_m[:, axis] = np.where(fresh, begins, goes_on)
            state.wander_mps[:, axis] = rate
