"""Few vehicles and many, from recorded truth: cost of each, and memory of many."""

from collections.abc import Collection, Iterator

from benchmarks.bench import Bench, security_us
from benchmarks.figures import Figure, Round, Sample

SCALING = Figure(
    "scaling_ratio", "cost of a vehicle-step at 20,000 vehicles ÷ at 1,000, 8 cells: all stages but tables", 1.2
)
PEAK = Figure("peak_rss_mb", "memory of the evaluating process at 20,000 vehicles, 8 cells", 1500.0)
FIGURES = (SCALING, PEAK)
SECONDS, FEW, MANY = 10.0, 1_000, 20_000
QUICK_SECONDS, QUICK_FEW, QUICK_MANY = 2.0, 100, 500


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of few and many vehicles."""
    seconds, few, many = (QUICK_SECONDS, QUICK_FEW, QUICK_MANY) if bench.quick else (SECONDS, FEW, MANY)
    scenario = bench.in_city("eight_cells")
    fleet = ("--set", f"duration_s={seconds}", "--recording", str(bench.recording(seconds)), "--vehicles")
    bench.evaluate("warm-up", *scenario, *fleet, str(few))
    for _ in range(bench.runs):
        some = bench.evaluate(f"{few} vehicles", *scenario, *fleet, str(few))
        all_ = bench.evaluate(f"{many} vehicles", *scenario, *fleet, str(many))
        costs = {"few_us": security_us(some["manifest"]), "many_us": security_us(all_["manifest"])}
        yield {
            SCALING.key: Sample(costs["many_us"] / costs["few_us"], costs),
            PEAK.key: Sample(all_["peak_rss_mb"], {"few_peak_rss_mb": some["peak_rss_mb"]}),
        }
