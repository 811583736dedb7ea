"""How vehicles know their lane: tracked by their own sensors, the nearest one, or told by the simulator."""

from dataclasses import dataclass

from gpsec.association.state import Association
from gpsec.association.tracked import associate
from gpsec.core.arrays import Floats, Ints
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.filters.noise import FilterNoise
from gpsec.hdmap.arrays import Roads
from gpsec.hdmap.search import NEAREST, TRACKED
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# How a position is matched under each: on the chain of the lane that is believed, or to any lane.
MODES = {"tracked": TRACKED, "nearest": NEAREST, "oracle": TRACKED}


@dataclass(frozen=True)
class Associating:
    """Says in every step which lane each track believes to be on.

    Attributes:
        kind: of `gpsec.types.constants.ASSOCIATIONS`. Under *oracle*, vehicles are told the lane that their camera
            shows: a bound. Under *nearest*, the paper's, each fix is matched to the lane that is nearest to it.
        roads: the map, with the layer of each profile.
        noise: what vehicles know of their sensors.
        step_s: length of a step.
    """

    kind: str
    roads: Roads
    noise: FilterNoise[Floats]
    step_s: float

    @property
    def mode(self) -> int:
        """How positions are matched."""
        return MODES[self.kind]

    def new_state(self, capacity: int) -> Table[Association]:
        """Return what `capacity` track rows that have seen nothing keep."""
        return Table(Association, capacity)

    def update(
        self,
        state: Association,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
    ) -> None:
        """Set `lane`, `lane_known` and `unmatched` of the track rows `rows`."""
        if self.kind == "tracked":
            threads.run(associate, rows, self.step_s, self.roads, self.noise, tracks, vehicles, seen, state)
            return
        tracks.lane_known[rows] = True
        tracks.unmatched[rows] = False
        if self.kind == "oracle":
            tracks.lane[rows] = vehicles.camera_lane[tracks.vehicle[rows]]
