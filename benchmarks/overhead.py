"""Whole runs against bare SUMO, in turn: what the security layer adds, and what a further cell adds."""

from collections.abc import Collection, Iterator
from typing import Any

from benchmarks.bench import Bench
from benchmarks.figures import Figure, Round, Sample
from benchmarks.processes import Usage
from gpsec.traffic.options import resolve_options
from gpsec.traffic.source import step_count

# Long enough that start and tables weigh as in a run that somebody waits for.
SECONDS, QUICK_SECONDS = 180.0, 5.0
SEED = 1
# Attack plans times defences.
FEW, MANY = 1 * 5, 8 * 8

OVERHEAD = Figure("overhead_ratio", "wall time, run of 1 plan and its twin × 5 defences ÷ bare SUMO, minus one", 0.15)
LOOP = Figure("overhead_loop_ratio", "the same inside the loop over the steps, without start and tables")
CPU = Figure("overhead_cpu_ratio", "the same in CPU seconds of all processes", 0.55)
MARGINAL = Figure("marginal_cell_ratio", "(64 cells − 5 cells) ÷ 59 ÷ bare SUMO, wall time", 0.03)
MARGINAL_CPU = Figure("marginal_cell_cpu_ratio", "the same in CPU seconds of all processes")
CELLS = Figure("sixty_four_cells_ratio", "wall time, run of 8 plans × 8 defences ÷ bare SUMO", 2.0)
FIGURES = (OVERHEAD, CPU, LOOP, MARGINAL, MARGINAL_CPU, CELLS)


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of bare SUMO, few cells and many cells."""
    seconds = QUICK_SECONDS if bench.quick else SECONDS
    duration = ("--duration", str(seconds), "--seed", str(SEED))
    options = resolve_options(bench.city.sumocfg, seed=SEED)
    stepping = ("benchmarks.bare", str(step_count(seconds, options.step_s)), *options.arguments)
    bench.gpsec("warm-up", *bench.in_city("sixty_four_cells"), "--duration", "5", "--seed", str(SEED))
    for _ in range(bench.runs):
        bare = bench.measure("bare SUMO", *stepping)
        made: Round = {}
        if {OVERHEAD.key, LOOP.key, CPU.key, MARGINAL.key, MARGINAL_CPU.key} & set(wanted):
            few, manifest = bench.gpsec("1 plan × 5 defences", *bench.in_city("one_plan"), *duration)
            _note_stages(bench, manifest)
            made |= _overhead(bare, few, manifest)
        if {MARGINAL.key, MARGINAL_CPU.key, CELLS.key} & set(wanted):
            many, _ = bench.gpsec("8 plans × 8 defences", *bench.in_city("sixty_four_cells"), *duration)
            made[CELLS.key] = Sample(many.wall_s / bare.wall_s, _walls(bare, many))
            if {MARGINAL.key, MARGINAL_CPU.key} & set(wanted):
                made |= _marginal(bare, few, many)
        yield made


def _overhead(bare: Usage, run: Usage, manifest: dict[str, Any]) -> Round:
    bare_loop_s, loop_s = float(bare.output.split()[-1]), manifest["loop_s"]
    of = {
        **_walls(bare, run),
        "bare_cpu_s": bare.cpu_s,
        "gpsec_cpu_s": run.cpu_s,
        "bare_loop_s": bare_loop_s,
        "gpsec_loop_s": loop_s,
        "vehicles_at_once": manifest["vehicle_steps"] / manifest["steps"],
        "tracks_per_vehicle": manifest["track_steps"] / manifest["vehicle_steps"],
    }
    return {
        OVERHEAD.key: Sample(run.wall_s / bare.wall_s - 1.0, of),
        CPU.key: Sample(run.cpu_s / bare.cpu_s - 1.0, of),
        LOOP.key: Sample(loop_s / bare_loop_s - 1.0, of),
    }


def _marginal(bare: Usage, few: Usage, many: Usage) -> Round:
    cells = MANY - FEW
    of = {"few_wall_s": few.wall_s, "many_wall_s": many.wall_s, "few_cpu_s": few.cpu_s, "many_cpu_s": many.cpu_s}
    return {
        MARGINAL.key: Sample((many.wall_s - few.wall_s) / cells / bare.wall_s, of | {"bare_wall_s": bare.wall_s}),
        MARGINAL_CPU.key: Sample((many.cpu_s - few.cpu_s) / cells / bare.cpu_s, of | {"bare_cpu_s": bare.cpu_s}),
    }


def _walls(bare: Usage, run: Usage) -> dict[str, float]:
    return {"bare_wall_s": bare.wall_s, "gpsec_wall_s": run.wall_s}


def _note_stages(bench: Bench, manifest: dict[str, Any]) -> None:
    on_road = 1e6 / manifest["road_steps"]
    costs = {"SUMO": manifest["sumo_s"] * on_road, "read": manifest["read_s"] * on_road}
    for stage, cost in (costs | manifest["stages_us_per_vehicle_step"]).items():
        bench.stages.setdefault(stage, []).append(cost)
