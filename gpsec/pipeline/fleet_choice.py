"""Who is equipped, and with which sensors: drawn from seed and vehicle alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate

from gpsec import noise
from gpsec.errors import GpsecError, nearest, shown
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
        return noise.plain_uniform(noise.vehicle_key(self.seed, first_life(departure.vehicle_id)), channel, 0)


@dataclass(frozen=True)
class Few:
    """Some vehicles of the fleet that `choice` draws, by their ids."""

    choice: FleetChoice
    vehicles: frozenset[str]

    def equipped(self, departure: Departure) -> bool:
        """Return whether a vehicle is one of them."""
        return first_life(departure.vehicle_id) in self.vehicles and self.choice.equipped(departure)


def first_life(vehicle_id: str) -> str:
    """Return SUMO's id of a vehicle that goes on as ``id#2``, ``id#3``, … after a jump or a teleport."""
    name, mark, life = vehicle_id.rpartition("#")
    return name if mark and life.isdigit() else vehicle_id


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
