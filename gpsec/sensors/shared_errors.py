"""What the receivers of a run have around them: the error that they share, and places of multipath."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.noise import COMMON_BIAS_EAST, COMMON_BIAS_NORTH, plain_normal, vehicle_key
from gpsec.core.tables import Table, blank
from gpsec.sensors.multipath import Places
from gpsec.sensors.sense import Sensors
from gpsec.sensors.table import BIAS, DECAY, KICK
from gpsec.types.vehicles import Measurements, Vehicles


class CommonError(NamedTuple):
    """The slow error that all receivers of a profile share; a row is a profile.

    Attributes:
        begun: (P,) it has been drawn.
        bias_m: (P, 2) east and north.
    """

    begun: Flags = blank(False)
    bias_m: Floats = blank(0.0, 2)


@dataclass(frozen=True)
class SharedErrors:
    """What is added to the fixes of all vehicles.

    Attributes:
        sensors: of the run; their mismatch says which share of the slow error is common.
        seed: of the run.
        places: of multipath.
    """

    sensors: Sensors
    seed: int
    places: Sequence[Places] = ()

    @property
    def is_quiet(self) -> bool:
        """Whether nothing is added."""
        return not self.places and self.sensors.mismatch.common_share == 0.0

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
        if self.sensors.mismatch.common_share > 0.0:
            self._advance(state, step)
        fresh = rows[measurements.fix_valid[rows]]
        if not len(fresh):
            return
        fix_m, true_m = measurements.fix_m, vehicles.rear_m[fresh]
        if self.sensors.mismatch.common_share > 0.0:
            fix_m[fresh] += state.bias_m[vehicles.profile[fresh]]
        for place in self.places:
            fix_m[fresh] += place.error_m(true_m)

    def _advance(self, state: CommonError, step: int) -> None:
        mismatch = self.sensors.mismatch
        part = mismatch.gnss_slow * sqrt(mismatch.common_share)
        key = vehicle_key(self.seed, "all vehicles")
        draws = plain_normal(key, COMMON_BIAS_EAST, step), plain_normal(key, COMMON_BIAS_NORTH, step)
        for profile, gnss in enumerate(self.sensors.stated.gnss):
            decay, sigma = (gnss[DECAY], gnss[KICK]) if state.begun[profile] else (0.0, gnss[BIAS])
            for axis, draw in enumerate(draws):
                state.bias_m[profile, axis] = decay * state.bias_m[profile, axis] + part * sigma * draw
        state.begun[:] = True
