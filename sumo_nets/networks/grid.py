"""Town networks: an irregular grid of streets with arterial roads, signals, priority junctions and roundabouts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from string import ascii_uppercase

from sumo_nets.alignment import Alignment, Segment, through
from sumo_nets.plan import Control, Plan

Cell = tuple[int, int]
"""Column and row of a junction."""

RING_RADIUS_M = 20.0
RING_GAP_RAD = 0.3
"""Half of the angle that a junction takes from a roundabout's ring."""

RING_APPROACH_M = 34.0
CORNER_M = 11.0
STUB_M = 220.0


@dataclass(frozen=True)
class Grid:
    """Where the junctions of a town lie and what its streets are like."""

    columns: Sequence[float]
    rows: Sequence[float]
    shifts: Mapping[Cell, tuple[float, float]] = field(default_factory=dict)
    column_lanes: Mapping[int, int] = field(default_factory=dict)
    row_lanes: Mapping[int, int] = field(default_factory=dict)
    omitted: frozenset[tuple[Cell, Cell]] = frozenset()
    bows: Mapping[tuple[Cell, Cell], tuple[float, ...]] = field(default_factory=dict)
    """Curved streets: the offset to the left (m) of one or of two corners on the way."""
    stubs: Mapping[Cell, float] = field(default_factory=dict)
    """Roads out of town: the heading (degrees) at which they leave a junction."""
    roundabouts: frozenset[Cell] = frozenset()
    unsignalled: frozenset[Cell] = frozenset()
    width_m: float = 3.2
    arterial_kmh: float = 50.0
    street_kmh: float = 40.0
    bow_radius_m: float = 70.0

    def place(self, cell: Cell) -> tuple[float, float]:
        """Coordinates (m) of a junction."""
        dx, dy = self.shifts.get(cell, (0.0, 0.0))
        return self.columns[cell[0]] + dx, self.rows[cell[1]] + dy

    def cells(self) -> list[Cell]:
        """All junctions."""
        return [(column, row) for column in range(len(self.columns)) for row in range(len(self.rows))]

    def streets(self) -> list[tuple[Cell, Cell, int]]:
        """Pairs of neighbouring junctions and the lanes each way between them."""
        result = []
        for column, row in self.cells():
            east, north = (column + 1, row), (column, row + 1)
            if column + 1 < len(self.columns) and ((column, row), east) not in self.omitted:
                result.append(((column, row), east, self.row_lanes.get(row, 1)))
            if row + 1 < len(self.rows) and ((column, row), north) not in self.omitted:
                result.append(((column, row), north, self.column_lanes.get(column, 1)))
        return result

    def stub_lanes(self, cell: Cell) -> int:
        """Lanes each way of the road out of town at a junction."""
        level = abs(math.cos(math.radians(self.stubs[cell]))) > 0.7
        return self.row_lanes.get(cell[1], 1) if level else self.column_lanes.get(cell[0], 1)


def lay(plan: Plan, grid: Grid) -> None:
    """Add a town's junctions and streets to a plan."""
    lanes_at: dict[Cell, list[int]] = {cell: [] for cell in grid.cells()}
    for start, end, lanes in grid.streets():
        lanes_at[start].append(lanes)
        lanes_at[end].append(lanes)
    for cell in grid.stubs:
        lanes_at[cell].append(grid.stub_lanes(cell))
    junctions = {
        cell: plan.junction(_label(cell), _control(grid, cell, lanes_at[cell]))
        for cell in grid.cells()
        if cell not in grid.roundabouts and lanes_at[cell]
    }
    arms: dict[Cell, list[tuple[float, int]]] = {cell: [] for cell in grid.roundabouts}

    def meet(cell: Cell, alignment: Alignment) -> tuple[int, float]:
        """Return the junction that a street out of this cell gets, and how far from the middle it begins."""
        if cell not in grid.roundabouts:
            return junctions[cell], max(lanes_at[cell]) * grid.width_m + CORNER_M
        junction = plan.junction(f"ring {_label(cell)} {len(arms[cell]) + 1}", "priority")
        arms[cell].append((alignment.start[2], junction))
        return junction, RING_APPROACH_M

    for start, end, lanes in grid.streets():
        line = _line(grid, start, end)
        start_junction, start_gap = meet(start, line)
        end_junction, end_gap = meet(end, line.reversed())
        plan.street(
            f"{_label(start)} {_label(end)}",
            line.slice(start_gap, line.length - end_gap),
            lanes=(lanes, lanes),
            speed_kmh=grid.arterial_kmh if lanes > 1 else grid.street_kmh,
            width_m=grid.width_m,
            rank=lanes,
            start=start_junction,
            end=end_junction,
        )
    for cell, heading in grid.stubs.items():
        x, y = grid.place(cell)
        angle = math.radians(heading)
        line = through([(x, y), (x + STUB_M * math.cos(angle), y + STUB_M * math.sin(angle))])
        junction, gap = meet(cell, line)
        lanes = grid.stub_lanes(cell)
        plan.street(
            f"{_label(cell)} out",
            line.slice(gap, line.length),
            lanes=(lanes, lanes),
            speed_kmh=grid.arterial_kmh if lanes > 1 else grid.street_kmh,
            width_m=grid.width_m,
            rank=lanes,
            start=junction,
        )
    for cell in sorted(grid.roundabouts):
        _ring(plan, grid, cell, arms[cell])


def _control(grid: Grid, cell: Cell, lanes: Sequence[int]) -> Control:
    """Signals where an arterial road is crossed."""
    return "signals" if max(lanes) > 1 and len(lanes) > 2 and cell not in grid.unsignalled else "priority"


def _line(grid: Grid, start: Cell, end: Cell) -> Alignment:
    """Centre line between two junctions, straight or with corners off the line."""
    (x0, y0), (x1, y1) = grid.place(start), grid.place(end)
    length = math.hypot(x1 - x0, y1 - y0)
    nx, ny = -(y1 - y0) / length, (x1 - x0) / length
    bows = grid.bows.get((start, end), ())
    corners = [
        (x0 + (x1 - x0) * part + nx * bow, y0 + (y1 - y0) * part + ny * bow, grid.bow_radius_m)
        for part, bow in zip({1: (0.5,), 2: (0.33, 0.67)}.get(len(bows), ()), bows, strict=True)
    ]
    return through([(x0, y0), *corners, (x1, y1)])


def _ring(plan: Plan, grid: Grid, cell: Cell, arms: Sequence[tuple[float, int]]) -> None:
    """Lay a roundabout's ring, counter-clockwise, from arm to arm."""
    x, y = grid.place(cell)
    ordered = sorted((angle % math.tau, junction) for angle, junction in arms)
    for (angle, junction), (following, following_junction) in zip(ordered, ordered[1:] + ordered[:1], strict=True):
        begin = angle + RING_GAP_RAD
        sweep = (following - angle) % math.tau - 2.0 * RING_GAP_RAD
        segment = Segment(
            x + RING_RADIUS_M * math.cos(begin),
            y + RING_RADIUS_M * math.sin(begin),
            begin + math.pi / 2.0,
            sweep * RING_RADIUS_M,
            1.0 / RING_RADIUS_M,
            1.0 / RING_RADIUS_M,
        )
        plan.street(
            f"ring {_label(cell)}",
            Alignment((segment,)),
            lanes=(1, 0),
            speed_kmh=30.0,
            width_m=grid.width_m + 1.0,
            rank=9,
            start=junction,
            end=following_junction,
        )


def _label(cell: Cell) -> str:
    """Return a junction's name on the town's map, like B3."""
    return f"{ascii_uppercase[cell[0]]}{cell[1] + 1}"
