"""Results of a sweep as pandas frames: ``sweep = gpsec.load("results/sweep")``, then ``sweep.safety`` and so on."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.core.errors import GpsecError
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.columns import read_checked
from gpsec.outcomes.effects import effects_table
from gpsec.outcomes.naming import seeded_name
from gpsec.outcomes.seeds import POOLED, pooled
from gpsec.running import results
from gpsec.running.results import Results
from gpsec.sweeps.desk import read_failures
from gpsec.sweeps.folder import LIST, SweepFolder, read_folder
from gpsec.sweeps.gather import HEAD, OF_VEHICLES, filters, part_file, typed
from gpsec.sweeps.points import ListedTask, Point
from gpsec.sweeps.shares import filtered, of_attack, with_draws
from gpsec.types.constants import MANIFEST


@dataclass(frozen=True)
class Sweep:
    """A sweep, as far as it has been made and gathered.

    Every table has `entry`, `scenario`, `seed` and the parameters before its own columns; a parameter is empty where it
    has no meaning, as that of one attack in the rows of another. `events` and `vehicles` have each row once, for the
    largest share: those of a share s are the rows whose `share_draw`, or `equipped_draw`, is below s.

    Attributes:
        folder: of the sweep.
    """

    folder: SweepFolder

    @property
    def parameters(self) -> tuple[str, ...]:
        """Keys that vary."""
        return tuple(self.folder.parameters)

    @cached_property
    def tasks(self) -> pd.DataFrame:
        """One row for each simulation: fingerprint, label, state (`done`, `failed` or `waiting`), what it says."""
        failures = read_failures(self.folder)
        rows = []
        for fingerprint, label in self.folder.labels.items():
            done = self.folder.store.has(fingerprint)
            failure = None if done else failures.get(fingerprint)
            state = "done" if done else "failed" if failure else "waiting"
            rows.append((fingerprint, label, state, failure.sentence if failure else ""))
        return pd.DataFrame(rows, columns=["fingerprint", "label", "state", "sentence"])

    @cached_property
    def detection(self) -> pd.DataFrame:
        """Seed × parameters × attack × detector."""
        return self._table("detection")

    @cached_property
    def localization(self) -> pd.DataFrame:
        """Seed × parameters × attack × defence."""
        return self._table("localization")

    @cached_property
    def safety(self) -> pd.DataFrame:
        """Seed × parameters × attack × defence."""
        return self._table("safety")

    @cached_property
    def events(self) -> pd.DataFrame:
        """Attacked vehicle × parameters × attack × defence."""
        return self._table("events")

    @cached_property
    def vehicles(self) -> pd.DataFrame:
        """Vehicle × parameters × attack × defence."""
        return self._table("vehicles")

    @cached_property
    def worlds(self) -> pd.DataFrame:
        """World of the closed loop × seed × parameters; empty without one."""
        return self._table("worlds")

    @cached_property
    def collisions(self) -> pd.DataFrame:
        """Collision in a world."""
        return self._table("collisions")

    def run(self, fingerprint: str) -> Results:
        """Return the results of one simulation, which has tables, a map and a manifest as any run.

        Raises:
            GpsecError: it is not in the store, or its files are not what they should be.
        """
        return results.load(self.folder.store.result(fingerprint))

    def over_seeds(
        self, replicates: int = 1000, confidence: float = 0.95, tell: Callable[[int, int], None] | None = None
    ) -> dict[str, pd.DataFrame]:
        """Return detection, localization and safety over the seeds: `seed` is gone, `n_runs` and intervals are there.

        Intervals are a bootstrap of runs, and within each of its vehicles, as in `gpsec run --seeds`.

        Args:
            replicates: of the bootstrap.
            confidence: of the intervals.
            tell: is told how many groups are done, of how many; one takes seconds.
        """
        bootstrap = Bootstrap(2026, replicates, confidence)
        groups: dict[str, list[ListedTask]] = {}
        for task in self._gathered():
            groups.setdefault(task.point.group, []).append(task)
        found: dict[str, list[pd.DataFrame]] = {name: [] for name in POOLED}
        for number, members in enumerate(groups.values(), start=1):
            for name, table in self._pooled(members, bootstrap).items():
                found[name].append(table)
            if tell is not None:
                tell(number, len(groups))
        return {name: pd.concat(parts, ignore_index=True) for name, parts in found.items() if parts}

    def effects(self, confidence: float = 0.95) -> pd.DataFrame:
        """Return what attacks do to the traffic: each world less its benign twin, over the seeds, with intervals."""
        worlds, head = self.worlds, ["entry", "scenario", *self.parameters]
        parts = []
        for key, rows in worlds.groupby(head, sort=False, dropna=False):
            names: dict[str, Any] = dict(zip(head, key, strict=True))
            parts.append(effects_table(rows, confidence).assign(**names))
        table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=head)
        return table[[*head, *(name for name in table.columns if name not in head)]]

    def _gathered(self) -> list[ListedTask]:
        tasks = [task for fingerprint in self.folder.labels for task in self.folder.tasks(fingerprint)]
        return [task for task in tasks if part_file(self.folder, POOLED[-1], task).exists()]

    def _table(self, name: str) -> pd.DataFrame:
        """Return one table of all simulations that have it, in the order of the plan."""
        paths = [path for task in self._gathered() if (path := part_file(self.folder, name, task)).exists()]
        if not paths:
            return pd.DataFrame(columns=[*HEAD, *self.parameters])
        return pd.concat([read_part(path) for path in paths], ignore_index=True)

    def _pooled(self, members: Sequence[ListedTask], bootstrap: Bootstrap) -> dict[str, pd.DataFrame]:
        point = members[0].point
        tables = {name: _of_seeds(self.folder, name, members) for name in (*POOLED, *OF_VEHICLES)}
        found: dict[str, list[pd.DataFrame]] = {name: [] for name in POOLED}
        for attack, share, equipped, keys in filters(point, tables["safety"]):
            all_of_it = share is None and equipped is None
            few = of_attack(tables, attack) if all_of_it else filtered(tables, attack, share, equipped)
            for name, table in pooled(point.scenario, few, bootstrap).items():
                found[name].append(self._headed(table, attack, point, keys))
        return {name: pd.concat(parts, ignore_index=True) for name, parts in found.items()}

    def _headed(self, table: pd.DataFrame, attack: str, point: Point, keys: dict[str, float]) -> pd.DataFrame:
        cell = point.cells.get(attack)
        stated = {**point.parameters, **(cell.parameters if cell else {}), **keys}
        head: dict[str, Any] = {"entry": point.entry, "scenario": point.scenario}
        for key, kind in self.folder.parameters.items():
            head[key] = typed([stated.get(key)] * len(table), table.index, kind)
        named = table.assign(**head, attack=cell.plan if cell else attack)
        return named[[*head, *(name for name in table.columns if name not in head)]]


def _of_seeds(sweep: SweepFolder, name: str, members: Sequence[ListedTask]) -> pd.DataFrame:
    """Return a table of runs that differ in their seeds, with plans and runs called as they were simulated."""
    parts = []
    for task in members:
        folder = sweep.store.result(task.fingerprint)
        table = read_checked(folder, name)
        if name in OF_VEHICLES:
            table = with_draws(table, task.point.seed)
        parts.append(table.assign(scenario=seeded_name(task.point.scenario, task.point.seed)))
    return pd.concat(parts, ignore_index=True)


def read_part(path: Path) -> pd.DataFrame:
    """Return a part of the dataset.

    Raises:
        GpsecError: it cannot be read.
    """
    try:
        return pd.read_parquet(path)
    except (OSError, ValueError) as error:
        raise GpsecError(f"{path}: expected a part of a dataset, found other data ({error})") from None


def load(folder: Path | str) -> Results | Sweep:
    """Return the results in a folder: a `Sweep` of what `gpsec sweep` has made, or the `Results` of a run.

    Raises:
        GpsecError: it is no such folder, or something in it is not what it should be.
    """
    place = Path(folder)
    if (place / LIST).is_file() and not (place / MANIFEST).is_file():
        return Sweep(read_folder(place))
    return results.load(place)
