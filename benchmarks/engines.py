"""The reference engine against the batched one, on the same vehicles and cells."""

from collections.abc import Collection, Iterator

from benchmarks.bench import Bench, security_us
from benchmarks.figures import Figure, Round, Sample

REFERENCE = Figure(
    "reference_ratio", "reference ÷ batched engine, 1,000 vehicles, 5 cells: all stages but tables", 300.0, True
)
FIGURES = (REFERENCE,)
SECONDS, VEHICLES = 2.0, 1_000
QUICK_SECONDS, QUICK_VEHICLES = 1.0, 50


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of the two engines, on recorded truth."""
    seconds, vehicles = (QUICK_SECONDS, QUICK_VEHICLES) if bench.quick else (SECONDS, VEHICLES)
    recording = str(bench.recording(seconds))
    # Attacked at once, so that everybody has a twin for most of this short time.
    run = (
        *(*bench.in_city("one_plan"), "--set", "plans.constant_bias.start_after_s=[0.0, 0.5]"),
        *("--set", f"duration_s={seconds}", "--recording", recording, "--vehicles", str(vehicles)),
    )
    bench.evaluate("warm-up", *run)
    for _ in range(bench.runs):
        batched = bench.evaluate("batched engine", *run)["manifest"]
        reference = bench.evaluate("reference engine", *run, "--set", "engine=reference")["manifest"]
        costs = {
            "batched_us": security_us(batched),
            "reference_us": security_us(reference),
            "tracks_per_vehicle": batched["track_steps"] / batched["vehicle_steps"],
        }
        yield {REFERENCE.key: Sample(costs["reference_us"] / costs["batched_us"], costs)}
