"""Which rows the branches of a run have, and the one rule by which they fork."""

from collections.abc import Sequence

import numpy as np

from gpsec.core.arrays import Ints
from gpsec.core.tables import Slots, Table
from gpsec.localization.history import Beliefs, History, Recorded
from gpsec.localization.state import Branches, Cells


class BranchRows:
    """The branches of one family.

    Attributes:
        columns: (k,) the defences of the family.
        active: rows of the branches of the tracks of this step, ascending.
    """

    def __init__(self, columns: Ints, states: int, snapshots: int) -> None:
        triangle = states * (states + 1) // 2
        self.columns = columns
        self.active: Ints = np.zeros(0, np.int32)
        self._table = Table(Branches, states=states, snapshots=snapshots, triangle=triangle)
        self._slots = Slots()

    @property
    def now(self) -> Branches:
        """The filters themselves."""
        return self._table.now

    def activate(self, tracks: Ints, capacity: int) -> None:
        """Begin a step with some of `capacity` track rows."""
        wanted = np.zeros(capacity + 1, np.bool_)  # with one for the track -1 of rows that are free
        wanted[tracks] = True
        self.active = np.flatnonzero(wanted[self.now.track]).astype(np.int32)

    def begin(self, cells: Cells, tracks: Ints) -> None:
        """Give each of `tracks` one fresh branch, in place of those that it had."""
        self._give_back(cells, tracks)
        fresh = self._take(len(tracks))
        self._table.reset(fresh)
        self.now.track[fresh] = tracks
        cells.branch[tracks[:, np.newaxis], self.columns] = fresh[:, np.newaxis]

    def fork(self, cells: Cells, source: Ints, target: Ints) -> None:
        """Let the tracks `target` go on from where `source` are, with branches of their own."""
        self._give_back(cells, target)
        branch = cells.branch[source[:, np.newaxis], self.columns]
        # Several tracks may go on from one, each with a copy of every branch.
        pairs = branch + self._table.capacity * np.arange(len(target))[:, np.newaxis]
        pair, group = np.unique(pairs, return_inverse=True)
        at, old = np.divmod(pair, self._table.capacity)
        new = self._take(len(old))
        self._table.copy(old, new)
        self.now.track[new] = target[at]
        cells.branch[target[:, np.newaxis], self.columns] = new[group].reshape(branch.shape)

    def part(self, cells: Cells, tracks: Ints) -> Ints:
        """Fork the branches of `tracks` whose defences are not of one response any more.

        Returns the rows of those that have given GNSS up, or taken it back.
        """
        cell = tracks[:, np.newaxis], self.columns
        branch, response = cells.branch[cell], cells.response[cell]
        changed = response != self.now.response[branch]
        if not changed.any():
            return tracks[:0]
        kept = set(branch[~changed].tolist())
        # Few cells change in a step: sorting them with numpy takes longer than this.
        pairs = list(zip(branch[changed].tolist(), response[changed].tolist(), strict=True))
        row_of: dict[tuple[int, int], int] = {}
        old = []
        for row, wanted in dict.fromkeys(pairs):
            if row in kept:
                old.append(row)
                row_of[row, wanted] = -1
            else:
                kept.add(row)
                row_of[row, wanted] = row
        if old:
            new = self._take(len(old))
            self._table.copy(np.array(old, np.int32), new)
            fresh = iter(new.tolist())
            row_of = {pair: next(fresh) if row < 0 else row for pair, row in row_of.items()}
            branch[changed] = [row_of[pair] for pair in pairs]
            cells.branch[cell] = branch
        moved = np.array(list(row_of.values()), np.int32)
        self.now.response[moved] = [wanted for _, wanted in row_of]
        return moved

    def _take(self, count: int) -> Ints:
        taken = np.array([self._slots.take() for _ in range(count)], np.int32)
        if self._slots.used > self._table.capacity:
            self._table.grow(2 * self._slots.used)
        return taken

    def _give_back(self, cells: Cells, tracks: Ints) -> None:
        branch = cells.branch[tracks[:, np.newaxis], self.columns]
        old = set(branch[branch >= 0].tolist())
        for row in old:
            self._slots.give_back(row)
        self.now.track[list(old)] = -1


class LocalizationState:
    """All that the filters of a run remember.

    Attributes:
        families: the branches of each family.
        history: odometry and camera of the vehicles.
        beliefs: the lanes that tracks believed to be on.
    """

    def __init__(
        self, defences: int, families: Sequence[BranchRows], history: Table[History], beliefs: Table[Beliefs]
    ) -> None:
        self._cells = Table(Cells, defences=defences)
        self.families = list(families)
        self.history = history
        self.beliefs = beliefs

    @property
    def cells(self) -> Cells:
        """The defences of every track."""
        return self._cells.now

    @property
    def recorded(self) -> Recorded:
        """What responses that go back start from."""
        return Recorded(self.history.now, self.beliefs.now.lane)

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        self._cells.grow(capacity)
        self.beliefs.grow(capacity)

    def reset(self, rows: Ints) -> None:
        """Begin anew in the track rows `rows`."""
        for family in self.families:
            family.begin(self.cells, rows)
        branch = self.cells.branch[rows]
        self._cells.reset(rows)
        self.cells.branch[rows] = branch

    def copy(self, source: Ints, target: Ints) -> None:
        """Let the tracks `target` go on from where the tracks `source` are."""
        for family in self.families:
            family.fork(self.cells, source, target)
        self.beliefs.copy(source, target)
        branch = self.cells.branch[target]
        self._cells.copy(source, target)
        self.cells.branch[target] = branch

    def part(self, rows: Ints) -> list[Ints]:
        """Fork branches where defences of the track rows `rows` have given GNSS up or taken it back.

        Returns, for each family, the rows of the branches that have.
        """
        tracks = rows[self.cells.parts[rows]]
        if not len(tracks):
            return [tracks] * len(self.families)
        self.cells.parts[tracks] = False
        return [family.part(self.cells, tracks) for family in self.families]

    def of(self, defence: int) -> tuple[Branches, Ints]:
        """Return the filters of the family of a defence, and the (M,) rows of those that it has."""
        family = next(family for family in self.families if defence in family.columns)
        return family.now, self.cells.branch[:, defence]
