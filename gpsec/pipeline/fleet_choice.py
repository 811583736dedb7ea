"""Who is equipped, and with which sensors: drawn from seed and vehicle alone."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import accumulate
from typing import Self

from gpsec.core import noise
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.traffic.names import first_life
from gpsec.traffic.source import Departure


@dataclass(frozen=True)
class FleetChoice:
    """How the fleet is drawn.

    Attributes:
        seed: of the run.
        equipped_share: for vehicles whose type does not say.
        shares: sensor profile -> share, for vehicles whose type does not say.
        profiles: names of the profiles of the run; their position is the index everywhere else.

    """

    seed: int
    equipped_share: float
    shares: Mapping[str, float]
    profiles: tuple[str, ...]

    def equipped(self, departure: Departure) -> bool:
        """Return whether a vehicle is part of the fleet."""
        share = self.equipped_share if departure.equipped_share is None else departure.equipped_share
        return self._draw(departure, noise.FLEET_EQUIPPED) < share

    def profile(self, departure: Departure) -> int:
        """Return the index of a vehicle's sensor profile."""
        if departure.sensors is not None:
            return self.profiles.index(departure.sensors)
        draw = self._draw(departure, noise.FLEET_PROFILE)
        for name, bound in zip(self.shares, accumulate(self.shares.values()), strict=True):
            if draw < bound:
                return self.profiles.index(name)
        return self.profiles.index(list(self.shares)[-1])

    def _draw(self, departure: Departure, channel: int) -> float:
        # A vehicle that goes on as id#2 keeps what it was given as id.
        return noise.plain_uniform(noise.vehicle_key(self.seed, departure.first_id), channel, 0)


@dataclass(frozen=True)
class Few:
    """Some vehicles of the fleet that `choice` draws, by SUMO's ids."""

    choice: FleetChoice
    vehicles: frozenset[str]

    @classmethod
    def named(cls, choice: FleetChoice, names: Collection[str]) -> Self:
        """Return those of a run that have such names; ``p#2`` may be another life of p, or be called so by SUMO."""
        return cls(choice, frozenset(names) | frozenset(map(first_life, names)))

    def equipped(self, departure: Departure) -> bool:
        """Return whether a vehicle is one of them."""
        return departure.first_id in self.vehicles and self.choice.equipped(departure)


def run_profiles(shares: Mapping[str, float], named: Mapping[str, str]) -> tuple[str, ...]:
    """Return the profiles of a run: those of the configuration, then those that vehicle types name.

    Args:
        shares: of the configuration.
        named: profile -> where it is named, for error messages.

    Raises:
        GpsecError: a vehicle type names a profile that there is not.

    """
    from gpsec.sensors.registry import PROFILES  # late: the process of SUMO draws who is equipped without it

    for name, where in named.items():
        if name not in PROFILES:
            raise GpsecError(
                f"{where}: gpsec.sensors: unknown sensor profile '{shown(name)}': {nearest(name, PROFILES)}"
            )
    return tuple(dict.fromkeys([*shares, *sorted(named)]))
