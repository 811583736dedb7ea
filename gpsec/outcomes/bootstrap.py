"""Bootstrap over vehicles: samples of one vehicle hang together, so whole vehicles are drawn, not samples."""

from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.core.noise import vehicle_key

# Draws that are held at once; part of the result, since the generator is asked for them chunk by chunk.
_DRAWS_AT_ONCE = 4_000_000


@dataclass(frozen=True)
class Bootstrap:
    """How intervals are made.

    Attributes:
        seed: of the run.
        replicates: number of resampled fleets, B.
        confidence: of the two-sided percentile interval.

    """

    seed: int
    replicates: int = 1000
    confidence: float = 0.95

    def sums(self, label: str, per_vehicle: Floats) -> Floats:
        """Return (B, C) sums over resampled vehicles of (V, C) sums of each vehicle.

        All columns share the same draws, so detectors and defences are compared on the same resampled fleets. The
        draws depend on seed, `label` and V alone, not on what else is in the table.
        """
        vehicles, columns = per_vehicle.shape
        sums = np.zeros((self.replicates, columns))
        if vehicles == 0:
            return sums
        generator = np.random.default_rng(vehicle_key(self.seed, label))
        chunk = max(1, _DRAWS_AT_ONCE // vehicles)
        values = np.ascontiguousarray(per_vehicle, np.float64)
        for start in range(0, self.replicates, chunk):
            part = sums[start : start + chunk]
            draws = generator.integers(0, vehicles, size=(len(part), vehicles), dtype=np.int32)
            add_drawn(draws, values, part)
        return sums

    def weights(self, label: str, runs: Ints) -> Floats:
        """Return (B, V) how often each vehicle is drawn, where (V,) `runs` numbers the run that each is of.

        Whole runs are drawn, as many as there are, and within each drawn run as many vehicles as it has (Davison and
        Hinkley, Bootstrap Methods and their Application, 1997, section 3.8). With one run, only vehicles are drawn.
        """
        generator = np.random.default_rng(vehicle_key(self.seed, label))
        numbers = np.unique(runs)
        drawn = np.zeros((self.replicates, len(runs)))
        if not len(numbers):
            return drawn
        times = generator.multinomial(len(numbers), np.full(len(numbers), 1.0 / len(numbers)), self.replicates)
        for place, number in enumerate(numbers):
            mine = np.flatnonzero(runs == number)
            share = np.full(len(mine), 1.0 / len(mine))
            drawn[:, mine] = generator.multinomial(times[:, place] * len(mine), share)
        return drawn


@kernel
def add_drawn(draws: Ints, values: Floats, sums: Floats) -> None:
    """Add the (V, C) values of the drawn vehicles (B, V) to (B, C) sums, one after the other."""
    for b in range(draws.shape[0]):
        for i in range(draws.shape[1]):
            for c in range(values.shape[1]):
                sums[b, c] += values[draws[b, i], c]
