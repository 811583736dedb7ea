"""From the store to one dataset: Parquet parts with entry, scenario, seed and parameters in front of each row."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.columns import read_checked
from gpsec.outcomes.digests import are_whole
from gpsec.outcomes.manifests import read_manifest
from gpsec.outcomes.seeds import POOLED, pooled
from gpsec.outcomes.tables import WORLD_TABLES, read_table, whole
from gpsec.sweeps.cells import EQUIPPED
from gpsec.sweeps.folder import TABLES_FOLDER, SweepFolder
from gpsec.sweeps.points import ListedTask, Point
from gpsec.sweeps.shares import filtered, with_draws

OF_VEHICLES = ("events", "vehicles")
SWEPT = (*POOLED, *OF_VEHICLES, *WORLD_TABLES)
"""Tables of the dataset."""
HEAD = ("entry", "scenario", "seed")
# A row of each seed has no interval: those are over seeds.
_BOUNDS = ("_lo", "_hi")
_POINT_ESTIMATE = Bootstrap(seed=0, replicates=1)
_DTYPES: dict[str, Any] = {"number": "float64", "flag": "boolean", "text": "str"}


def gather_tables(sweep: SweepFolder, tell: Callable[[int, int], None]) -> list[str]:
    """Write the parts of the dataset that are missing; return the fingerprints of runs that are not whole any more.

    Those are removed from the store, so that they are made again. Parts that no run of the list has any more go, too.
    `tell` is told how many runs have been looked at, of how many.

    Raises:
        GpsecError: the disk refuses.
    """
    with in_a_sentence(f"{sweep.path / TABLES_FOLDER}: cannot be written"):
        spoilt, wanted = [], set[str]()
        for number, fingerprint in enumerate(sweep.labels, start=1):
            if not sweep.store.has(fingerprint):
                continue
            tasks = sweep.tasks(fingerprint)
            names = {_part(task): task for task in tasks}
            wanted |= set(names)
            todo = [task for name, task in names.items() if not (_folder(sweep, POOLED[-1]) / name).exists()]
            if todo and not _write_parts(sweep, todo):
                sweep.store.discard(fingerprint)
                spoilt.append(fingerprint)
            tell(number, len(sweep.labels))
        for path in (sweep.path / TABLES_FOLDER).glob("*/*.parquet"):
            if path.name not in wanted:
                path.unlink()
    return spoilt


def part_file(sweep: SweepFolder, table: str, task: ListedTask) -> Path:
    """Return where the part of a table is that a simulation has for an entry."""
    return _folder(sweep, table) / _part(task)


def _part(task: ListedTask) -> str:
    return f"{task.point.entry}-{task.fingerprint[:32]}.parquet"


def _folder(sweep: SweepFolder, table: str) -> Path:
    return sweep.path / TABLES_FOLDER / table


def _write_parts(sweep: SweepFolder, tasks: list[ListedTask]) -> bool:
    """Write the parts of one run; return whether its tables are what it has written."""
    folder = sweep.store.result(tasks[0].fingerprint)
    try:
        manifest = read_manifest(folder)
        if manifest is None or not are_whole(folder, manifest):
            return False
        run = {name: read_checked(folder, name) for name in (*POOLED, *OF_VEHICLES)}
        worlds = {name: read_table(folder, name) for name in WORLD_TABLES if (folder / f"{name}.csv").exists()}
    except GpsecError:
        return False
    for task in tasks:
        point = task.point
        made = {**{name: raw_rows(run[name], point) for name in OF_VEHICLES}, **worlds}
        made |= figures(run, point)
        # The last one says that all are there.
        for name in (*OF_VEHICLES, *worlds, *POOLED):
            frame = _headed(made[name], point, sweep.parameters)
            path = part_file(sweep, name, task)
            with whole(path) as partial:
                frame.to_parquet(partial, index=False, compression="zstd")
    return True


def raw_rows(table: pd.DataFrame, point: Point) -> pd.DataFrame:
    """Return rows of vehicles, each once, with the parameters of their plan and the draws that say their shares."""
    return _with_cells(with_draws(table, point.seed), point)


def figures(run: Mapping[str, pd.DataFrame], point: Point) -> dict[str, pd.DataFrame]:
    """Return `POOLED` of one run with a row for each share, without intervals."""
    drawn = {name: with_draws(run[name], point.seed) if name in OF_VEHICLES else run[name] for name in run}
    found: dict[str, list[pd.DataFrame]] = {name: [] for name in POOLED}
    for attack, share, equipped, keys in filters(point, run["safety"]):
        if share is None and equipped is None:
            tables = {name: run[name][run[name]["attack"] == attack] for name in POOLED}
        else:
            few = filtered(drawn, attack, share, equipped)
            tables = pooled(point.scenario, few, _POINT_ESTIMATE)
        for name, table in tables.items():
            found[name].append(table.assign(**keys))
    columns = {name: [each for each in run[name].columns if not each.endswith(_BOUNDS)] for name in POOLED}
    return {
        name: _with_cells(
            pd.concat(parts, ignore_index=True)[
                [*columns[name], *(key for key in _shares_of(point) if any(key in part for part in parts))]
            ],
            point,
        )
        for name, parts in found.items()
    }


def filters(point: Point, safety: pd.DataFrame) -> Iterator[tuple[str, float | None, float | None, dict[str, float]]]:
    """Yield each attack of a simulation with each share: None for the largest, which was simulated, and its keys."""
    for attack in safety["attack"].unique():
        cell = point.cells.get(attack)
        for equipped in point.equipped or (None,):
            for share in cell.shares if cell is not None and cell.shares else (None,):
                keys: dict[str, float] = {}
                if equipped is not None:
                    keys[EQUIPPED] = equipped
                if share is not None and cell is not None:
                    keys[cell.share_key] = share
                whole_fleet = equipped is None or equipped == point.equipped[-1]
                all_attacked = share is None or cell is None or share == cell.shares[-1]
                yield str(attack), None if all_attacked else share, None if whole_fleet else equipped, keys


def _shares_of(point: Point) -> list[str]:
    keys = [cell.share_key for cell in point.cells.values() if cell.share_key]
    return list(dict.fromkeys([*([EQUIPPED] if point.equipped else []), *keys]))


def _with_cells(table: pd.DataFrame, point: Point) -> pd.DataFrame:
    """Return a table whose attacks are called as in the scenario, with the parameters that each has beside."""
    if not point.cells:
        return table
    keys = list(dict.fromkeys(key for cell in point.cells.values() for key in cell.parameters))
    added = {
        key: table["attack"].map({name: _plain(cell.parameters.get(key)) for name, cell in point.cells.items()})
        for key in keys
    }
    names = {name: cell.plan for name, cell in point.cells.items()}
    return table.assign(attack=table["attack"].map(lambda name: names.get(name, name)), **added)


def _headed(table: pd.DataFrame, point: Point, parameters: Mapping[str, str]) -> pd.DataFrame:
    """Return a table with entry, scenario, seed and all parameters of the sweep in front."""
    head: dict[str, Any] = {"entry": point.entry, "scenario": point.scenario, "seed": point.seed}
    frame = pd.DataFrame({key: [value] * len(table) for key, value in head.items()}, index=table.index)
    for key, kind in parameters.items():
        values = table[key].tolist() if key in table else [point.parameters.get(key)] * len(table)
        frame[key] = typed(values, table.index, kind)
    rest = table[[name for name in table.columns if name not in frame]]
    return pd.concat([frame.astype({"entry": "str", "scenario": "str", "seed": "int64"}), rest], axis=1)


def typed(values: Sequence[Any], index: pd.Index, kind: str) -> "pd.Series[Any]":
    """Return a column of a parameter; `kind` is one of `number`, `flag` and `text`."""
    column: pd.Series[Any] = pd.Series([_plain(value) for value in values], index, dtype=_DTYPES[kind])
    return column


def _plain(value: Any) -> Any:
    """Return a value of a grid as a cell of a table holds it."""
    return value if value is None or isinstance(value, str | bool | int | float) else json.dumps(value)
