"""How long it takes until something happens: with everything compiled, and the first time."""

import tempfile
from collections.abc import Collection, Iterator

from benchmarks.bench import Bench
from benchmarks.city import ROOT, SUMO
from benchmarks.figures import Figure, Round, Sample

STARTUP = Figure("startup_s", "gpsec run on slow_curve for 1 s of simulated time, warm caches")
RATIO = Figure("startup_ratio", "the same ÷ sumo on the same")
JIT = Figure("jit_s", "gpsec run on slow_curve for 20 s: with an empty cache, minus with a warm one", 30.0)
FIGURES = (STARTUP, RATIO, JIT)
SCENARIO = ROOT / "scenarios" / "slow_curve"


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of short runs, then rounds of first runs."""
    if {STARTUP.key, RATIO.key} & set(wanted):
        bench.gpsec("warm-up", SCENARIO, "--duration", "1")
        for _ in range(bench.runs):
            yield _startup(bench)
    if JIT.key in wanted:
        for _ in range(bench.runs):
            yield _first_run(bench)


def _startup(bench: Bench) -> Round:
    sumo = bench.measure("sumo, 1 s", str(SUMO), "-c", str(SCENARIO / "slow_curve.sumocfg"), "--end", "1")
    gpsec, _ = bench.gpsec("gpsec, 1 s", SCENARIO, "--duration", "1")
    of = {"gpsec_s": gpsec.wall_s, "gpsec_cpu_s": gpsec.cpu_s, "sumo_s": sumo.wall_s}
    return {STARTUP.key: Sample(gpsec.wall_s, of), RATIO.key: Sample(gpsec.wall_s / sumo.wall_s, of)}


def _first_run(bench: Bench) -> Round:
    with tempfile.TemporaryDirectory(dir=bench.work) as cache:
        environment = {"GPSEC_CACHE": cache}
        cold, manifest = bench.gpsec("empty cache", SCENARIO, "--duration", "20", environment=environment)
        warm, _ = bench.gpsec("warm cache", SCENARIO, "--duration", "20", environment=environment)
    of = {"cold_s": cold.wall_s, "warm_s": warm.wall_s, "in_the_loop_s": manifest["compile_s"]}
    return {JIT.key: Sample(cold.wall_s - warm.wall_s, of)}
