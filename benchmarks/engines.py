"""The reference engine against the batched one, on the same vehicles and cells."""

from collections.abc import Collection, Iterator

from benchmarks.bench import Bench, security_us
from benchmarks.figures import Figure, Round, Sample

REFERENCE = Figure(
    "reference_ratio",
    "reference ÷ batched engine, 1,000 vehicles: all stages but SUMO, reading and tables",
    300.0,
    True,
)
FIGURES = (REFERENCE,)
SECONDS, SHARE = 3.0, 0.4
QUICK_SECONDS, QUICK_SHARE = 1.0, 0.1


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of the two engines."""
    seconds, share = (QUICK_SECONDS, QUICK_SHARE) if bench.quick else (SECONDS, SHARE)
    size = ("--duration", str(seconds), "--set", f"fleet.equipped_share={share}", "--set", "outcomes.bootstrap=10")
    scenario = bench.in_city("one_plan")
    bench.gpsec("warm-up", *scenario, *size)
    for _ in range(bench.runs):
        _, batched = bench.gpsec("batched engine", *scenario, *size)
        _, reference = bench.gpsec("reference engine", *scenario, *size, "--engine", "reference")
        costs = {"batched_us": security_us(batched), "reference_us": security_us(reference)}
        yield {REFERENCE.key: Sample(costs["reference_us"] / costs["batched_us"], costs)}
