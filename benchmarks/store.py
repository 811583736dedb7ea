"""Keeps what was measured: `bench.json`, and tables of it."""

import json
import os
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table

from benchmarks.bench import spread
from benchmarks.figures import Figure, Round
from gpsec.core.threads import cores

PACKAGES = ("libsumo", "numba", "numpy")


class FigureStore:
    """The figures so far; the file is whole after every round.

    Figures of earlier calls stay, as long as they were measured on the same machine in the same way; each has the
    commit that it was measured on.
    """

    def __init__(self, path: Path, figures: tuple[Figure, ...], quick: bool) -> None:
        from gpsec.pipeline.manifest import git_commit  # takes long to import

        self._path = path
        self._figures = {figure.key: figure for figure in figures}
        self._commit = git_commit()
        self._begun: set[str] = set()
        self._content: dict[str, Any] = {"machine": _machine(), "quick": quick}
        former = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
        if not all(former.get(key) == value for key, value in self._content.items()):
            former = {}
        self._content["figures"] = former.get("figures", {})
        self._content["stages_us_per_vehicle_step"] = former.get("stages_us_per_vehicle_step", {})

    def add(self, made: Round, stages: Mapping[str, list[float]]) -> None:
        """Take in a round and write the file anew."""
        entries = self._content["figures"]
        for key, sample in made.items():
            if key not in self._begun:
                self._begun.add(key)
                entries[key] = {"samples": [], "of": []}
            figure, entry = self._figures[key], entries[key]
            samples = [*entry["samples"], round(float(sample.value), 4)]
            middle = spread(samples)
            entries[key] = {
                "what": figure.what,
                **middle,
                "goal": figure.wish or None,
                "met": figure.met(middle["median"]),
                "samples": samples,
                "of": [*entry["of"], {name: round(float(value), 4) for name, value in sample.of.items()}],
                "git_commit": self._commit,
            }
        self._content["figures"] = {key: entries[key] for key in self._figures if key in entries}
        if stages:
            costs = {stage: spread([round(value, 4) for value in values]) for stage, values in stages.items()}
            self._content["stages_us_per_vehicle_step"] = costs
        self._path.parent.mkdir(parents=True, exist_ok=True)
        making = self._path.with_suffix(".tmp")
        making.write_text(json.dumps(self._content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
        making.replace(self._path)

    def tables(self, wide: bool) -> list[Table]:
        """Return the figures, with what they are where there is room for it, and where the time goes."""
        figures = _table("figure", "median", "min", "max", "goal", "", *(["what"] if wide else []))
        for key, entry in self._content["figures"].items():
            met = {True: "met", False: "[red]missed[/]", None: ""}[entry["met"]]
            figures.add_row(key, *_numbers(entry), entry["goal"] or "", met, *([entry["what"]] if wide else []))
        costs = _table("1 plan × 5 defences, µs per vehicle-step", "median", "min", "max")
        for stage, entry in self._content["stages_us_per_vehicle_step"].items():
            costs.add_row(stage, *_numbers(entry))
        return [table for table in (figures, costs) if table.row_count]


def _table(first: str, *others: str) -> Table:
    table = Table(box=box.SIMPLE, pad_edge=False)
    table.add_column(first, no_wrap=True)
    for name in others:
        is_number = name in ("median", "min", "max")
        table.add_column(name, no_wrap=name != "what", justify="right" if is_number else "left")
    return table


def _numbers(entry: Mapping[str, float]) -> list[str]:
    return [
        f"{entry[name]:.3g}" if abs(entry[name]) < 100 else f"{entry[name]:.0f}" for name in ("median", "min", "max")
    ]


def _machine() -> dict[str, Any]:
    return {
        "cpu": _cpu_model(),
        "cores": cores(),
        "memory_mb": os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2**20,
        "system": platform.platform(),
        "python": platform.python_version(),
        **{package: version(package) for package in PACKAGES},
    }


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor()
