"""Pictures in a run: what a small share of the fleet costs beside SUMO, and ten vehicles in cores of real time."""

from collections.abc import Collection, Iterator

from benchmarks.bench import Bench
from benchmarks.city import ROOT
from benchmarks.figures import Figure, Round, Sample
from gpsec.traffic.options import resolve_options
from gpsec.traffic.source import step_count

SECONDS, QUICK_SECONDS = 90.0, 12.0
SCENARIO = ROOT / "scenarios" / "highway"
# Enough vehicles that what they cost stands out from the rest of the run.
MEASURED_SHARE, SHARE = 0.03, 0.002
TEN, RATE_HZ = 10, 10.0
_LEAN = ("--set", "plans=[]", "--set", "defences=[]", "--set", 'detection.detectors=["chi_square"]')

FEW = Figure("pixels_share_ratio", "CPU of pictures of 0.2 % of `highway`, one a step, ÷ CPU of bare SUMO", 1.0)
COST = Figure("pixels_ten_cores", "ten vehicles with pictures at 10 Hz in real time, cores", 0.7)
FIGURES = (FEW, COST)


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of bare SUMO, of a run, and of the same run in which some vehicles see pictures; CPU time."""
    seconds = QUICK_SECONDS if bench.quick else SECONDS
    options = resolve_options(SCENARIO / "highway.sumocfg", seed=1)
    common = (*_LEAN, "--duration", str(seconds), "--seed", "1", "--jobs", "1")
    seeing = ("--set", "fleet.camera.source=image", "--set", f"fleet.camera.image_share={MEASURED_SHARE}")
    for _ in range(bench.runs):
        bare = bench.measure(
            "bare SUMO", "benchmarks.bare", str(step_count(seconds, options.step_s)), *options.arguments
        )
        blind, _ = bench.gpsec("without pictures", SCENARIO, *common)
        seen, manifest = bench.gpsec("with pictures", SCENARIO, *common, *seeing)
        taken = sum(one["pictures"] for one in manifest["pixels"]["vehicles"].values())
        picture_s = (seen.cpu_s - blind.cpu_s) / max(taken, 1)
        of = {"pictures": taken, "picture_ms": 1e3 * picture_s, "bare_cpu_s": bare.cpu_s}
        yield {
            FEW.key: Sample(picture_s * SHARE * manifest["vehicle_steps"] / bare.cpu_s, of),
            COST.key: Sample(picture_s * TEN * RATE_HZ, of),
        }
