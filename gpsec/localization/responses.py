"""What a defence does while GNSS is isolated."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.hdmap.arrays import MapView
from gpsec.localization.history import History, Recall
from gpsec.localization.noise import FilterNoise
from gpsec.localization.state import FilterState
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class World(NamedTuple):
    """What filters work with in every step.

    Attributes:
        view: the HD map.
        noise: sensor figures of the profiles.
        step_s: length of a step.
    """

    view: MapView
    noise: FilterNoise[Floats]
    step_s: float


@dataclass(frozen=True)
class Cells:
    """The n cells (track row, defence) that a response has to correct in this step: all are isolated.

    Attributes:
        row, defence: (n,) each.
        entered: (n,) isolated since this very step.

    """

    row: Ints
    defence: Ints
    entered: Flags


class Response(ABC):
    """Corrects the estimate of isolated cells, after they were propagated with odometer and gyro."""

    name: ClassVar[str]
    # A response that never isolates leaves everything as it is, alarm or not.
    isolates: ClassVar[bool] = True
    # The filter learns scale and gyro bias (`gpsec.localization.learning`) instead of taking them for noise.
    learns: ClassVar[bool] = False
    # On an alarm the filter restarts from its past; such a response implements `rewind`.
    rolls_back: ClassVar[bool] = False

    @abstractmethod
    def correct(
        self, cells: Cells, filters: FilterState, tracks: Tracks, vehicles: Vehicles, seen: Measurements, world: World
    ) -> None:
        """Correct the filters of `cells` with what is left when GNSS is not trusted."""

    def rewind(  # noqa: B027 - most responses have no past to go back to
        self,
        cells: Cells,
        filters: FilterState,
        history: History,
        tracks: Tracks,
        vehicles: Vehicles,
        world: World,
        recall: Recall,
    ) -> None:
        """Replace the filters of `cells`, which an alarm has just isolated, by what they were, brought up to now.

        It comes before `correct`: this step's motion is to be applied, its camera is not.
        """
