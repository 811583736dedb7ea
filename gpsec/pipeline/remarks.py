"""What a user should know of a run: of its net and its steps, and of vehicles that do not fit or become many rows."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from gpsec.core.errors import shown
from gpsec.hdmap.map import HDMap
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.recorder import Outcomes
from gpsec.outcomes.state import OUT_OF_LANE
from gpsec.outcomes.study import Study
from gpsec.pipeline.build import Ground
from gpsec.pipeline.loop import Loop
from gpsec.pipeline.manifest import Counts
from gpsec.traffic.source import Frame
from gpsec.types.tracks import SAMPLE_S
from gpsec.types.vehicles import Vehicles

# Where more than this share of the rows are further ones of the same vehicles, counts of rows mislead.
_MANY_ROWS = 0.1
_LANE, _JUNCTION, _JUMP, _AWAY = range(4)


class Remarks:
    """Watches a run for what makes its counts mislead, and says so at the end."""

    def __init__(self, hd_map: HDMap) -> None:
        self._map = hd_map
        sides = hd_map.sides
        self._narrowest_m = float(sides.width_m[~sides.internal].min())
        self._wide: dict[str, str] = {}  # the vehicle -> what is wider than what
        self._owner: dict[str, str] = {}  # name of a further row -> the vehicle
        self._why: Counter[int] = Counter()

    def before(self, frame: Frame, loop: Loop) -> None:
        """Look at who goes on as a new vehicle in a step that the loop has not taken yet."""
        again = [departure for departure in frame.departures if departure.first_id != departure.vehicle_id]
        if not again:
            return
        last = {loop.fleet[row].sumo_id: int(loop.vehicles.lane[row]) for row in frame.left}
        for departure in again:
            self._owner[departure.vehicle_id] = departure.first_id
            lane = int(frame.lane[np.searchsorted(frame.rows, departure.row)])
            self._why[self._jump(last.get(departure.first_id), lane)] += 1

    def _jump(self, before: int | None, lane: int) -> int:
        """Return what kind of jump leads from one lane to another within a step; None is no lane of a step before."""
        if before is None:
            return _AWAY
        if before == lane:
            return _JUMP
        edges = {self._map.lane_ids[index].rpartition("_")[0] for index in (before, lane)}
        return _LANE if len(edges) == 1 else _JUNCTION

    def after(self, frame: Frame, loop: Loop) -> None:
        """Look at the vehicles of a step that the loop has taken."""
        vehicles: Vehicles = loop.vehicles
        wide = frame.rows[vehicles.width_m[frame.rows] >= self._narrowest_m]
        if not len(wide):
            return
        sides, lane = self._map.sides, vehicles.lane[wide]
        touching = (vehicles.width_m[wide] >= sides.width_m[lane]) & ~sides.internal[lane]
        for row in wide[touching].tolist():
            lane_m, on = sides.width_m[vehicles.lane[row]], shown(self._map.lane_ids[vehicles.lane[row]])
            name = loop.fleet[row].sumo_id
            self._wide.setdefault(name, f"'{shown(name)}' of {vehicles.width_m[row]:.2f} m on '{on}' of {lane_m:.2f} m")

    def sentences(self, counts: Counts, outcomes: Outcomes) -> Iterator[str]:
        """Yield a sentence for each thing that there is to say of a run that is over."""
        vehicles = counts.vehicles - counts.resumed
        if counts.against_steps:
            yield (
                f"{counts.against_steps} of {counts.vehicle_steps} vehicle steps were left out: the vehicle's"
                " lane leads the other way there (it overtakes on an oncoming lane, or is turning round)"
            )
        if self._wide:
            yield (
                f"{_part(len(self._wide), vehicles)} are as wide as a lane that they drive on, or wider, such as"
                f" {next(iter(self._wide.values()))}: they touch a line there wherever their estimate is"
            )
        if counts.resumed:
            yield f"{vehicles} vehicles became {counts.vehicles} rows (id#2, …): {self._reasons()}"
        if counts.resumed > _MANY_ROWS * counts.vehicles:
            yield self._shares(outcomes.tracks(), outcomes.study)

    def _reasons(self) -> str:
        inside = bool(self._map.sides.internal.any())
        junction = "" if inside else ": the net has no lanes inside junctions"
        said = {
            _LANE: "a lane change in one step (with sublanes, traffic.lateral_resolution_m, it takes its time)",
            _JUNCTION: f"a jump from edge to edge{junction}",
            _JUMP: "a move that the speed does not explain",
            _AWAY: "a teleport or a stay, or with the id of one that has left",
        }
        return ", ".join(f"{self._why[kind]} after {what}" for kind, what in said.items() if self._why[kind])

    def _shares(self, tracks: ClosedTracks, study: Study) -> str:
        """Return how many of the vehicles themselves would have left their lane, with the last defence."""
        parts = []
        for number, plan in enumerate(study.plans):
            chosen = tracks.of_plan(number)
            owner = np.array([self._owner.get(name, name) for name in chosen.vehicle_id.tolist()], np.str_)
            left = chosen.state.first_step[:, -1, OUT_OF_LANE] >= 0
            parts.append(f"{plan} {_part(len(set(owner[left].tolist())), len(set(owner.tolist())))}")
        return (
            "tables count rows; of the vehicles themselves would have left their lane with"
            f" {study.defence_names[-1]}: {', '.join(parts)}"
        )


def _part(some: int, of: int) -> str:
    return f"{some} of {of} vehicles ({some / max(of, 1):.0%})"


def beforehand(ground: Ground) -> list[str]:
    """Return what the user should know of a run that is valid but unusual."""
    said = []
    if ground.options.step_s > SAMPLE_S + 1e-9:
        said.append(
            f"thresholds were calibrated for a residual every {SAMPLE_S:g} s, this run has one every"
            f" {ground.options.step_s:g} s: false-alarm rates will differ"
        )
    if stretched := ground.hd_map.stretched:
        said.append(
            f"{len(stretched)} lanes, such as '{shown(stretched[0])}', have a shape more than a tenth longer or shorter"
            " than their length: vehicles are faster or slower there than SUMO says"
        )
    return said
