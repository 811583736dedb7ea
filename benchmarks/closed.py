"""The closed loop: a world against the open loop of the same scenario, and what commands cost."""

import json
from collections.abc import Collection, Iterator
from typing import Any

from benchmarks.bench import Bench
from benchmarks.city import ROOT
from benchmarks.figures import Figure, Round, Sample

SECONDS, QUICK_SECONDS = 180.0, 12.0
SCENARIO = ROOT / "scenarios" / "town"
PLAN = 'plans=[{attack="stealth",share=0.5}]'

WORLD = Figure("closed_world_ratio", "time in the loop, world of stealth, undefended ÷ open loop of the same", 1.25)
COMMANDS = Figure("command_us", "carrying out commands, all vehicles steered, µs a steered vehicle-step", 2.0)
FIGURES = (WORLD, COMMANDS)


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of the open loop, of a world, and of one in which everybody is steered."""
    seconds = QUICK_SECONDS if bench.quick else SECONDS
    common = ("--duration", str(seconds), "--seed", "1", "--jobs", "1", "--set", PLAN)
    for _ in range(bench.runs):
        _, opened = bench.gpsec("open loop", SCENARIO, *common)
        world = _world(bench, *common, "--set", 'closed_loop.worlds=[{plan="stealth"}]')
        every = _world(bench, *common, "--set", "closed_loop.steer=all", "--set", "closed_loop.worlds=[{}]")
        us = every["closed_loop"]["command_us_per_steered_vehicle_step"]
        yield {
            WORLD.key: Sample(
                world["loop_s"] / opened["loop_s"], {"open_s": opened["loop_s"], "closed_s": world["loop_s"]}
            ),
            COMMANDS.key: Sample(us, {"steered": every["closed_loop"]["steered_vehicle_steps"]}),
        }


def _world(bench: Bench, *options: str) -> dict[str, Any]:
    """Run a scenario in closed loop and return the manifest of its last world."""
    bench.gpsec("closed loop", SCENARIO, "--closed-loop", *options)
    manifest = json.loads((bench.work / "out" / "manifest.json").read_text("utf-8"))
    last: dict[str, Any] = manifest["scenarios"][-1]
    return last
