"""The closed loop: a world against the open loop of the same scenario, two at once, and what commands cost."""

import json
import os
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

from benchmarks.bench import Bench
from benchmarks.city import ROOT
from benchmarks.figures import Figure, Round, Sample

SECONDS, QUICK_SECONDS = 180.0, 12.0
SCENARIO = ROOT / "scenarios" / "town"
PLAN = 'plans=[{attack="stealth",share=0.5}]'

WORLD = Figure("closed_world_ratio", "time in the loop, world of stealth, undefended ÷ open loop of the same", 1.25)
COMMANDS = Figure("command_us", "carrying out commands, all vehicles steered, µs a steered vehicle-step", 2.0)
TWO = Figure("two_worlds_ratio", "two worlds side by side on two cores ÷ one alone, all of it on one core", 1.15)
FIGURES = (WORLD, COMMANDS, TWO)
EVERYBODY = ("--set", "closed_loop.steer=all", "--set", "closed_loop.worlds=[{}]")


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of the open loop, of worlds alone, and of two at once."""
    seconds = QUICK_SECONDS if bench.quick else SECONDS
    if {WORLD.key, COMMANDS.key} & set(wanted):
        yield from _alone(bench, seconds)
    if TWO.key in wanted:
        yield from _side_by_side(bench, seconds)


def _alone(bench: Bench, seconds: float) -> Iterator[Round]:
    """Yield rounds of the open loop, of a world, and of one in which everybody is steered."""
    common = ("--duration", str(seconds), "--seed", "1", "--jobs", "1", "--set", PLAN)
    for _ in range(bench.runs):
        _, opened = bench.gpsec("open loop", SCENARIO, *common)
        world = _world(bench, *common, "--set", 'closed_loop.worlds=[{plan="stealth"}]')
        every = _world(bench, *common, *EVERYBODY)
        us = every["closed_loop"]["command_us_per_steered_vehicle_step"]
        yield {
            WORLD.key: Sample(
                world["loop_s"] / opened["loop_s"], {"open_s": opened["loop_s"], "closed_s": world["loop_s"]}
            ),
            COMMANDS.key: Sample(us, {"steered": every["closed_loop"]["steered_vehicle_steps"]}),
        }


def _side_by_side(bench: Bench, seconds: float) -> Iterator[Round]:
    """Yield rounds of two worlds at once on two cores, and of the same one after the other on one; half of that is one.

    A machine with one core has no such figure.
    """
    cores = sorted(os.sched_getaffinity(0))
    if len(cores) < 2:
        return
    both = ("--closed-loop", "--duration", str(seconds), "--seeds", "1-2", "--set", PLAN, *EVERYBODY)
    for _ in range(bench.runs):
        with _bound_to(cores[:2]):
            at_once, _ = bench.gpsec("two worlds at once", SCENARIO, *both, "--jobs", "2")
        with _bound_to(cores[:1]):
            in_turn, _ = bench.gpsec("two worlds in turn", SCENARIO, *both, "--jobs", "1")
        ratio = 2.0 * at_once.wall_s / in_turn.wall_s
        yield {TWO.key: Sample(ratio, {"at_once_s": at_once.wall_s, "in_turn_s": in_turn.wall_s})}


@contextmanager
def _bound_to(cores: Collection[int]) -> Iterator[None]:
    """Let processes that are started use these cores alone."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def _world(bench: Bench, *options: str) -> dict[str, Any]:
    """Run a scenario in closed loop and return the manifest of its last world."""
    bench.gpsec("closed loop", SCENARIO, "--closed-loop", *options)
    manifest = json.loads((bench.work / "out" / "manifest.json").read_text("utf-8"))
    last: dict[str, Any] = manifest["scenarios"][-1]
    return last
