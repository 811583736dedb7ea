"""Memory over an hour of steady traffic."""

from collections.abc import Collection, Iterator

import numpy as np

from benchmarks.bench import SCENARIOS, Bench
from benchmarks.city import SMALL_CITY, build
from benchmarks.figures import Figure, Round, Sample

GROWTH = Figure(
    "growth_mb_per_hour",
    "slope of resident memory over the second half of an hour, 150 vehicles that come and go",
    20.0,
)
FIGURES = (GROWTH,)
SECONDS, QUICK_SECONDS = 3600.0, 120.0


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of one long run each."""
    seconds = QUICK_SECONDS if bench.quick else SECONDS
    build(SMALL_CITY)
    where = ("--set", f"sumocfg={SMALL_CITY.sumocfg}", "--set", f"duration_s={seconds}")
    for _ in range(bench.runs):
        told = bench.evaluate(f"{seconds:g} simulated seconds", SCENARIOS / "one_plan", *where)
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
