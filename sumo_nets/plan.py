"""What a network is made of, before it becomes OpenDRIVE: streets with lane sections, and junctions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from sumo_nets.alignment import Alignment, Pose

Control = Literal["signals", "priority", "merge"]
Lanes = tuple[int, int]
"""Lanes along the alignment, and lanes against it."""

FIRST_JUNCTION_ID = 1000
FIRST_CONNECTING_ID = 10000

COMFORT_MPS2 = 2.2
"""Lateral acceleration that the advisory speed of a curve allows."""

SHORTEST_ZONE_M = 30.0


@dataclass(frozen=True)
class Section:
    """A stretch of a street with the same lanes and the same speed limit."""

    s: float
    lanes: Lanes
    speed_mps: float


@dataclass(frozen=True)
class Street:
    """A road between two junctions (or dead ends: None)."""

    id: int
    name: str
    alignment: Alignment
    sections: tuple[Section, ...]
    width_m: float
    rank: int
    start: int | None
    end: int | None


@dataclass(frozen=True)
class LaneLink:
    """Across a junction: street and lane (0 is the rightmost in driving direction) to street and lane."""

    from_street: int
    from_lane: int
    to_street: int
    to_lane: int


@dataclass(frozen=True)
class Junction:
    """Where streets meet; without explicit links the turns follow from the arms' headings."""

    id: int
    name: str
    control: Control
    links: tuple[LaneLink, ...] = ()


@dataclass(frozen=True)
class Arm:
    """One street at one junction; the pose looks into the junction."""

    street: Street
    at_end: bool

    @property
    def pose(self) -> Pose:
        """Pose of the reference line where the street meets the junction, looking into it."""
        if self.at_end:
            return self.street.alignment.end
        x, y, heading = self.street.alignment.start
        return x, y, heading + math.pi

    @property
    def lanes_in(self) -> int:
        """Lanes that enter the junction."""
        return self.street.sections[-1].lanes[0] if self.at_end else self.street.sections[0].lanes[1]

    @property
    def lanes_out(self) -> int:
        """Lanes that leave the junction."""
        return self.street.sections[-1].lanes[1] if self.at_end else self.street.sections[0].lanes[0]

    def lane_id(self, lane: int, entering: bool) -> int:
        """OpenDRIVE id of a lane, counted from the right in driving direction."""
        count = self.lanes_in if entering else self.lanes_out
        distance = count - lane
        return -distance if entering == self.at_end else distance

    def border(self, lane: int, entering: bool) -> Pose:
        """Pose of a lane's left border where it meets the junction, in driving direction."""
        x, y, heading = self.pose
        count = self.lanes_in if entering else self.lanes_out
        heading = heading if entering else heading + math.pi
        offset = (count - 1 - lane) * self.street.width_m
        return x + math.sin(heading) * offset, y - math.cos(heading) * offset, heading


@dataclass
class Plan:
    """A whole network."""

    name: str
    geo_reference: str
    curve_resolution_m: float = 1.0
    netconvert: tuple[str, ...] = ()
    streets: list[Street] = field(default_factory=list)
    junctions: list[Junction] = field(default_factory=list)

    def junction(self, name: str, control: Control) -> int:
        """Add a junction and return its id."""
        junction = Junction(FIRST_JUNCTION_ID + len(self.junctions), name, control)
        self.junctions.append(junction)
        return junction.id

    def merge(self, name: str, links: Sequence[LaneLink]) -> None:
        """Give the junction of this name the lane links that it is to have."""
        for index, junction in enumerate(self.junctions):
            if junction.name == name:
                self.junctions[index] = Junction(junction.id, name, junction.control, tuple(links))
                return
        raise KeyError(name)

    def street(
        self,
        name: str,
        alignment: Alignment,
        *,
        lanes: Lanes | Sequence[tuple[float, Lanes]],
        speed_kmh: float,
        width_m: float,
        rank: int = 1,
        start: int | None = None,
        end: int | None = None,
    ) -> Street:
        """Add a street; `lanes` may change along it, the speed drops in tight curves by itself."""
        changes = [(0.0, lanes)] if isinstance(lanes[0], int) else lanes
        sections = _sections(alignment, changes, speed_kmh)  # type: ignore[arg-type]
        street = Street(len(self.streets) + 1, name, alignment, sections, width_m, rank, start, end)
        self.streets.append(street)
        return street

    def arms(self, junction: Junction) -> list[Arm]:
        """Return the streets that meet at a junction."""
        arms = []
        for street in self.streets:
            if street.start == junction.id:
                arms.append(Arm(street, at_end=False))
            if street.end == junction.id:
                arms.append(Arm(street, at_end=True))
        return arms


PlanMaker = Callable[[], Plan]


def tmerc(latitude_deg: float, longitude_deg: float) -> str:
    """Geo-reference of a local transverse Mercator projection around a place."""
    return f"+proj=tmerc +lat_0={latitude_deg} +lon_0={longitude_deg} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"


def _sections(alignment: Alignment, changes: Sequence[tuple[float, Lanes]], speed_kmh: float) -> tuple[Section, ...]:
    """Cut a street where its lanes or its speed limit change."""
    zones = speed_zones(alignment, speed_kmh)
    starts = sorted({s for s, _ in changes} | {s for s, _ in zones})
    sections: list[Section] = []
    for s in starts:
        lanes = [value for at, value in changes if at <= s][-1]
        speed = [value for at, value in zones if at <= s][-1]
        sections.append(Section(s, lanes, speed))
    return tuple(sections)


def speed_zones(alignment: Alignment, speed_kmh: float) -> list[tuple[float, float]]:
    """Where each speed limit begins (m) and what it is (m/s): curves get the speed they can be driven at."""
    zones: list[list[float]] = []
    s = 0.0
    for segment in alignment.segments:
        curvature = max(abs(segment.k0), abs(segment.k1))
        kmh = speed_kmh
        if curvature > 0:
            kmh = min(kmh, max(10.0, 5.0 * math.floor(3.6 * math.sqrt(COMFORT_MPS2 / curvature) / 5.0)))
        zones.append([s, s + segment.length, kmh])
        s += segment.length
    while True:
        zones = _join_equal(zones)
        for index, (begin, end, kmh) in enumerate(zones):
            around = zones[max(index - 1, 0) : index] + zones[index + 1 : index + 2]
            slower = [zone[2] for zone in around if zone[2] < kmh]
            if slower and end - begin < SHORTEST_ZONE_M:
                zones[index][2] = max(slower)
                break
        else:
            return [(begin, round(kmh / 3.6, 2)) for begin, _, kmh in zones]


def _join_equal(zones: list[list[float]]) -> list[list[float]]:
    """Join neighbouring zones of the same speed, drop empty ones."""
    joined: list[list[float]] = []
    for begin, end, kmh in zones:
        if end - begin < 1e-6:
            continue
        if joined and joined[-1][2] == kmh:
            joined[-1][1] = end
        else:
            joined.append([begin, end, kmh])
    return joined
