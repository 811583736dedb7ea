"""The set-up of FusionRipper, in open and closed loop: ``python -m benchmarks.fusion_ripper``.

Builds a local road and a highway with the lane widths of its paper, chooses d and f for each defence by trying all
combinations on the traffic of one seed, as the attacker of the paper does offline, and attacks the traffic of other
seeds with them. An attack succeeds where the vehicle deviates by the paper's distance within two minutes. What has
been run is not run again, so that it can be interrupted.
"""

import argparse
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Console
from rich.table import Table

from benchmarks.city import BUILT, ROOT
from gpsec.outcomes.metrics import wilson_interval
from gpsec.sumo.home import program

SCENARIO = ROOT / "benchmarks" / "scenarios" / "fusion_ripper"
# The published ranges of d and f; the grid is coarser than one that takes half a day.
D_M, F = (0.3, 0.6, 1.2, 2.0), (1.1, 1.3, 1.6, 2.0)
PROFILING_SEED = 1
# Attacks that begin later than so long before the end of the simulation are not counted.
WHOLE_S = 60.0
DEFENCES = ("never+none", "never+gate", "lstm_glr+ukf", "joint+ukf5_rollback")
WIDTH_M = 2.11
_DISPLACED, _ERROR = "displaced_max_m", "max_cross_track_m"


@dataclass(frozen=True)
class Road:
    """A road of the paper.

    Attributes:
        name: of it.
        lanes: of each direction.
        lane_m: their width.
        speed_mps: that is allowed.
        per_hour: vehicles of each direction.
        shoulder_m: beyond the outermost lane.
    """

    name: str
    lanes: int
    lane_m: float
    speed_mps: float
    per_hour: int
    shoulder_m: float

    @property
    def line_m(self) -> float:
        """Deviation at which a vehicle touches its line: stage two begins."""
        return 0.5 * (self.lane_m - WIDTH_M)

    @property
    def goals(self) -> dict[str, float]:
        """Deviation of each goal of the paper: off the road beyond the shoulder, and wholly in the next lane."""
        return {"off road": self.line_m + self.shoulder_m, "wrong way": 0.5 * (self.lane_m + WIDTH_M)}


# The paper's deviations are 0.895 and 2.405 m on local roads, 1.945 and 2.855 m on highways.
ROADS = (Road("local", 1, 2.7, 13.9, 500, 0.6), Road("highway", 2, 3.6, 27.8, 900, 1.2))


def build(road: Road) -> Path:
    """Build a road of 4 km in wide bends, both directions side by side; return the configuration."""
    folder = BUILT / "fusion_ripper" / road.name
    config = folder / f"{road.name}.sumocfg"
    if config.is_file():
        return config
    folder.mkdir(parents=True, exist_ok=True)
    way_m = np.arange(0.0, 4001.0, 25.0)
    shape = " ".join(f"{x:.1f},{60.0 * np.sin(x / 400.0):.3f}" for x in way_m)
    back = " ".join(reversed(shape.split()))
    (folder / "plain.nod.xml").write_text(
        f'<nodes><node id="a" x="0" y="0"/><node id="b" x="4000" y="{60.0 * np.sin(10.0):.3f}"/></nodes>'
    )
    same = f'numLanes="{road.lanes}" width="{road.lane_m}" speed="{road.speed_mps}" spreadType="right"'
    (folder / "plain.edg.xml").write_text(
        f'<edges><edge id="ab" from="a" to="b" shape="{shape}" {same}/>'
        f'<edge id="ba" from="b" to="a" shape="{back}" {same}/></edges>'
    )
    given = ["--node-files", "plain.nod.xml", "--edge-files", "plain.edg.xml", "--no-turnarounds", "-o", "road.net.xml"]
    subprocess.run([program("netconvert"), *given], cwd=folder, check=True, capture_output=True)
    flows = "".join(
        f'<flow id="{edge}" type="car" begin="0" end="3600" vehsPerHour="{road.per_hour}" departSpeed="max"'
        f' departLane="random"><route edges="{edge}"/></flow>'
        for edge in ("ab", "ba")
    )
    (folder / "road.rou.xml").write_text(f'<routes><vType id="car" width="{WIDTH_M}" length="4.9"/>{flows}</routes>')
    config.write_text(
        '<configuration><net-file value="road.net.xml"/><route-files value="road.rou.xml"/>'
        '<step-length value="0.1"/><lateral-resolution value="0.8"/><begin value="0"/><end value="3600"/>'
        "</configuration>"
    )
    return config


def plan_name(d_m: float, f: float) -> str:
    """Return the name of the plan of a combination."""
    return f"d{d_m:g}_f{f:g}"


def plans(road: Road, combinations: Sequence[tuple[float, float]]) -> str:
    """Return a value of ``--set plans=…`` with a plan for each combination of d and f."""
    when = "share=1.0,start_after_s=[0.0,10.0],duration_s=[120.0,120.0]"
    watch = f"trigger_m={road.line_m:.3f},timeout_s=120.0,cap_m=10.0"
    parts = [
        f'{{attack="two_stage",name="{plan_name(d_m, f)}",{when},{watch},d_m={d_m},f={f}}}' for d_m, f in combinations
    ]
    return f"plans=[{','.join(parts)}]"


def run(out: Path, road: Road, seconds: float, *options: str) -> Path:
    """Run the scenario on a road into `out`, which is kept where it is the same; return `out`."""
    command = [
        sys.executable,
        "-m",
        "gpsec",
        "run",
        str(SCENARIO),
        "--duration",
        str(seconds),
        "--resume",
        "--no-report",
    ]
    command += ["--set", f"sumocfg={build(road)}", "--out", str(out), *options]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return out


def successes(folder: Path, road: Road, seconds: float, column: str) -> pd.DataFrame:
    """Return a row for each attack that lasted long enough to be counted, with a flag for each goal."""
    events = pd.read_csv(folder / "events.csv")
    counted = events[events["start_s"] <= seconds - WHOLE_S].copy()
    for goal, least_m in road.goals.items():
        counted[goal] = counted[column] >= least_m
    return counted


def best(found: pd.DataFrame, defence: str) -> tuple[float, float]:
    """Return d and f by which most attacks on a defence succeed: the wrong way first, then off the road."""
    mine = found[found["defence"] == defence]
    shares = {goal: mine.groupby("attack")[goal].mean().to_dict() for goal in ("wrong way", "off road")}
    order = {plan_name(d_m, f): (d_m, f) for d_m, f in product(D_M, F)}
    name = max(order, key=lambda one: (*(shares[goal][one] for goal in shares), -order[one][0], -order[one][1]))
    return order[name]


def rows(road: Road, out: Path, seeds: Sequence[int], seconds: float) -> Iterator[dict[str, object]]:
    """Yield, for each goal and defence, d and f and how many attacks succeeded in open and in closed loop."""
    combinations = list(product(D_M, F))
    tried = run(
        out / f"{road.name}-profiling", road, seconds, "--seed", str(PROFILING_SEED), "--set", plans(road, combinations)
    )
    profiled = successes(tried, road, seconds, _ERROR)
    chosen = {defence: best(profiled, defence) for defence in DEFENCES}
    settings = ["--set", plans(road, list(dict.fromkeys(chosen.values())))]
    some = ["--seeds", ",".join(map(str, seeds))]
    opened = successes(run(out / f"{road.name}-open", road, seconds, *settings, *some), road, seconds, _ERROR)
    asked = ",".join(f'{{plan="{plan_name(*chosen[name])}",defence="{name}"}}' for name in DEFENCES)
    world = ["--closed-loop", "--set", f"closed_loop.worlds=[{asked}]"]
    folder = run(out / f"{road.name}-closed", road, seconds, *settings, *some, *world)
    closed = successes(folder, road, seconds, _DISPLACED)
    worlds = pd.read_csv(folder / "worlds.csv")
    for defence, goal in product(DEFENCES, road.goals):
        d_m, f = chosen[defence]
        plan = plan_name(d_m, f)
        steered = worlds[(worlds["plan"] == plan) & (worlds["defence"] == defence)]
        of_world = closed[closed["scenario"].isin(steered["scenario"]) & (closed["defence"] == defence)]
        of_open = opened[(opened["attack"] == plan) & (opened["defence"] == defence)]
        yield {
            "road": road.name,
            "goal": goal,
            "deviation_m": round(road.goals[goal], 3),
            "defence": defence,
            "d_m": d_m,
            "f": f,
            **_share("open", of_open[goal]),
            **_share("closed", of_world[goal]),
            "crashed": int((of_world["crash_s"].notna()).sum()),
        }


def _share(name: str, flags: "pd.Series[bool]") -> dict[str, object]:
    count, of = int(flags.sum()), len(flags)
    low, high = wilson_interval(np.array([float(count)]), np.array([float(of)]), 0.95)
    return {f"{name}": count, f"{name}_of": of, f"{name}_lo": float(low.value[0]), f"{name}_hi": float(high.value[0])}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what has not been run yet, print the table and write it; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fusion_ripper", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "fusion_ripper", help="folder of runs and table")
    parser.add_argument("--seeds", type=int, nargs="+", default=[2, 3], metavar="N", help="of what is attacked")
    parser.add_argument("--seconds", type=float, default=180.0, help="simulated time of a run")
    parser.add_argument(
        "--roads", nargs="+", default=[road.name for road in ROADS], choices=[road.name for road in ROADS]
    )
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    found = pd.DataFrame(
        row
        for road in ROADS
        if road.name in options.roads
        for row in rows(road, options.out, options.seeds, options.seconds)
    )
    found.to_csv(options.out / "fusion_ripper.csv", index=False)
    drawn = Table("road", "goal", "defence", "d, f", "open loop", "closed loop", "crashed")
    for row in found.to_dict("records"):
        cells = [
            f"{row[of]} of {row[f'{of}_of']} ({row[f'{of}_lo']:.0%} to {row[f'{of}_hi']:.0%})"
            for of in ("open", "closed")
        ]
        goal = f"{row['goal']}, {row['deviation_m']:g} m"
        drawn.add_row(
            str(row["road"]), goal, str(row["defence"]), f"{row['d_m']:g} m, {row['f']:g}", *cells, str(row["crashed"])
        )
    Console(emoji=False, width=140).print(drawn)
    return 0


if __name__ == "__main__":
    sys.exit(main())
