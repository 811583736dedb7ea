"""What every group of figures is measured with."""

import json
import statistics
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks import processes
from benchmarks.city import CITY, SMALL_CITY, City, build
from benchmarks.processes import Usage

SCENARIOS = Path(__file__).parent / "scenarios"


@dataclass
class Bench:
    """How measurements are made.

    Attributes:
        runs: rounds of each group.
        quick: see that everything works, in a short time and with few vehicles; the figures mean nothing.
        work: folder for files in the making.
        console: where each run is told.
        stages: µs per vehicle-step of each stage, a list with an entry a round.

    """

    runs: int
    quick: bool
    work: Path
    console: Console
    stages: dict[str, list[float]] = field(default_factory=dict)

    @cached_property
    def city(self) -> City:
        """What is driven through; it is built when it is first asked for."""
        chosen = SMALL_CITY if self.quick else CITY
        with self.console.status(f"building {chosen.name}, once"):
            build(chosen)
        return chosen

    def measure(self, label: str, *command: str, environment: Mapping[str, str] | None = None) -> Usage:
        """Run a module of Python (or, with a slash in its name, a program) and tell what it took."""
        whole = command if "/" in command[0] else (sys.executable, "-m", *command)
        with self.console.status(label):
            usage = processes.measure(whole, self.work / "log", environment)
        self.console.print(f"  {label}: {usage.wall_s:.2f} s, {usage.cpu_s:.2f} s CPU", highlight=False)
        return usage

    def gpsec(
        self, label: str, scenario: Path, *options: str, environment: Mapping[str, str] | None = None
    ) -> tuple[Usage, dict[str, Any]]:
        """Run ``gpsec run`` on a scenario, without its report; return what it took and its manifest."""
        out = self.work / "out"
        command = ("gpsec", "run", str(scenario), "--out", str(out), "--overwrite", "--no-report", *options)
        usage = self.measure(label, *command, environment=environment)
        manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
        return usage, manifest["scenarios"][0]

    def in_city(self, name: str) -> tuple[Path, str, str]:
        """Return a scenario of the benchmark, with the option that sets it in the city."""
        return SCENARIOS / name, "--set", f"sumocfg={self.city.sumocfg}"

    def recording(self, seconds: float) -> Path:
        """Record the traffic of the city anew."""
        target = self.work / "city.npz"
        self.measure("recording", "benchmarks.synthetic_traffic", str(self.city.sumocfg), str(seconds), str(target))
        return target

    def evaluate(self, label: str, scenario: Path, *options: str) -> dict[str, Any]:
        """Run a scenario in a process that tells its own memory; see `benchmarks.evaluate`."""
        answer = self.work / "answer.json"
        self.measure(label, "benchmarks.evaluate", str(scenario), str(answer), *options)
        told: dict[str, Any] = json.loads(answer.read_text())
        return told


def security_us(manifest: Mapping[str, Any]) -> float:
    """Return what a vehicle-step costs beside SUMO and reading it, in µs: all stages but the tables at the end."""
    stages: dict[str, float] = manifest["stages_us_per_vehicle_step"]
    return sum(cost for stage, cost in stages.items() if stage != "files")


def spread(values: list[float]) -> dict[str, float]:
    """Return the median and the extremes of samples."""
    return {"median": statistics.median(values), "min": min(values), "max": max(values)}
