"""Memory over an hour of steady traffic."""

from collections.abc import Collection, Iterator
from pathlib import Path

import numpy as np

from benchmarks.bench import SCENARIOS, Bench
from benchmarks.city import ROOT
from benchmarks.figures import Figure, Round, Sample
from sumo_nets.demand import END_S

GROWTH = Figure("growth_mb_per_hour", "slope of resident memory over the second half of an hour of slow_curve", 20.0)
FIGURES = (GROWTH,)
SECONDS, QUICK_SECONDS = 3600, 240


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of one long run each."""
    seconds = QUICK_SECONDS if bench.quick else SECONDS
    sumocfg = _lengthened("slow_curve", seconds, bench.work)
    for _ in range(bench.runs):
        told = bench.evaluate(f"{seconds} s of slow_curve", SCENARIOS / "one_plan", "--set", f"sumocfg={sumocfg}")
        time_s, memory_mb = np.array(told["memory_mb"]).T
        late = time_s >= 0.5 * seconds
        slope = float(np.polyfit(time_s[late] / 3600.0, memory_mb[late], 1)[0])
        manifest = told["manifest"]
        of = {
            "vehicles": manifest["vehicles"],
            "vehicles_at_once": manifest["vehicle_steps"] / manifest["steps"],
            "first_mb": float(memory_mb[late][0]),
            "last_mb": float(memory_mb[-1]),
            "peak_rss_mb": told["peak_rss_mb"],
        }
        yield {GROWTH.key: Sample(slope, of)}


def _lengthened(name: str, seconds: int, folder: Path) -> Path:
    """Write a scenario of the project whose traffic goes on for longer; return its configuration."""
    source = ROOT / "scenarios" / name
    routes = (source / f"{name}.rou.xml").read_text(encoding="utf-8")
    (folder / f"{name}.rou.xml").write_text(routes.replace(f'end="{END_S}"', f'end="{seconds}"'), encoding="utf-8")
    config = (source / f"{name}.sumocfg").read_text(encoding="utf-8")
    config = config.replace(f'<end value="{END_S}"', f'<end value="{seconds}"')
    for file in ("../../sumo_nets", "../vehicle_types", f"{name}.add"):
        config = config.replace(file, str((source / file).resolve()))
    target = folder / f"{name}.sumocfg"
    target.write_text(config, encoding="utf-8")
    return target
