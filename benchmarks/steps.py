"""Whether results depend on the step length: ``python -m benchmarks.steps``.

One net and one set of attacks at several step lengths. What has been run is not run again, so that it can be
interrupted. Traffic is simulated at the same step, and SUMO's drivers do not do the same at another one: so figures
agree within their intervals, and are not equal.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd
from rich.console import Console
from rich.table import Table

from benchmarks.city import ROOT
from gpsec.attacks.plans import plan_config
from gpsec.console.bars import display
from gpsec.paper.pool import Estimate, detection, false_alarms, of_defence, of_detector, read_runs, share
from gpsec.running.workers import run_scenarios
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.sensors.registry import PROFILES
from gpsec.types.points import PER_SAMPLE

STEPS_S = (0.1, 0.05, 0.033, 0.02, 0.01)
DETECTORS = ("chi_square", "cusum", "isolation_forest", "lstm_glr", "joint")
WHEN = {"share": 0.5, "start_after_s": [0.0, 20.0], "duration_s": [10.0, 20.0]}
PLANS = (
    {"attack": "constant_bias", "bias_m": 2.4, **WHEN},
    {"attack": "stealth", "gamma_m": 0.02, "delta": 1.05, **WHEN},
)
# In whose lane a vehicle is that steers by its estimate.
_DEPARTED = ("out_of_lane", "wrong_way", "off_road")


def scenario(step_s: float, seed: int, duration_s: float) -> Scenario:
    """Return the town at a step length, its fleet divided evenly among the profiles."""
    town = load_scenario(ROOT / "scenarios" / "town")
    changes = {
        "name": f"step-{step_s:g}-seed-{seed}",
        "seed": seed,
        "duration_s": duration_s,
        "traffic": town.traffic.model_copy(update={"step_s": step_s}),
        "fleet": town.fleet.model_copy(update={"profile": dict.fromkeys(PROFILES, 1.0 / len(PROFILES))}),
        "detection": town.detection.model_copy(update={"detectors": DETECTORS, "rates": (PER_SAMPLE,)}),
        "defences": (
            Defence(detector="never", response="none"),
            *(Defence(detector=detector, response="ukf", rate=PER_SAMPLE) for detector in DETECTORS),
        ),
        "plans": tuple(plan_config(dict(plan), "steps") for plan in PLANS),
        "outcomes": town.outcomes.model_copy(update={"bootstrap": 10}),
    }
    return town.model_copy(update=changes)


def figures(events: pd.DataFrame, vehicles: pd.DataFrame, detector: str) -> Iterator[tuple[str, str, Estimate]]:
    """Yield (attack, quantity, figure) of the vehicles of one profile and step length.

    All is at 1e-3 per sample, since a run is too short for rarer false alarms.
    """
    yield "none", "false_alarms_per_h", false_alarms(vehicles, detector)
    for plan in PLANS:
        attack = str(plan["attack"])
        found = detection(of_detector(events, detector, attack))
        yield attack, "detected_share", found["detected_share"]
        yield attack, "delay_mean_s", found["delay_mean_s"]
        yield attack, "f1", found["f1"]
        defended = of_defence(events, f"{detector}+ukf", attack)
        yield attack, "departed_share", share(defended, defended["outcome"].isin(_DEPARTED))


def table(folders: dict[float, list[Path]]) -> pd.DataFrame:
    """Return a row for every step length, profile, detector, attack and quantity."""
    rows = []
    for step_s, runs in folders.items():
        events, vehicles = read_runs(runs, "events"), read_runs(runs, "vehicles")
        for profile in PROFILES:
            mine = events[events["profile"] == profile], vehicles[vehicles["profile"] == profile]
            for detector in DETECTORS:
                for attack, quantity, found in figures(*mine, detector):
                    rows.append((profile, detector, attack, quantity, step_s, *_numbers(found)))
    names = ["profile", "detector", "attack", "quantity", "step_s", "value", "low", "high", "n"]
    return pd.DataFrame(rows, columns=names)


def _numbers(found: Estimate) -> tuple[float | None, float | None, float | None, int]:
    return found.value, found.low, found.high, found.n


def apart(shorter: pd.DataFrame, measured: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of `shorter` whose interval does not meet that of the same quantity at 0.1 s."""
    key = ["profile", "detector", "attack", "quantity"]
    first = measured[measured["step_s"] == STEPS_S[0]].set_index(key)[["low", "high"]]
    both = shorter.join(first.add_suffix("_first"), on=key)
    return both[(both["low"] > both["high_first"]) | (both["high"] < both["low_first"])]


def show(measured: pd.DataFrame, console: Console) -> None:
    """Print one line for every profile, detector and attack, the steps side by side."""
    for (attack, quantity), part in measured.groupby(["attack", "quantity"], sort=False):
        drawn = Table(title=f"{quantity}, {attack}")
        for name in ("profile", "detector", *(f"{step_s:g} s" for step_s in STEPS_S)):
            drawn.add_column(name)
        for (profile, detector), row in part.groupby(["profile", "detector"], sort=False):
            cells = [
                "" if pd.isna(value) else f"{value:.2f} ({low:.2f}, {high:.2f})"
                for value, low, high in zip(row["value"], row["low"], row["high"], strict=True)
            ]
            drawn.add_row(str(profile), str(detector), *cells)
        console.print(drawn)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what has not been run yet, and show what came of it; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.steps", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "steps", help="folder of runs and table")
    parser.add_argument("--seeds", type=int, default=2, help="runs of each step length")
    parser.add_argument("--seconds", type=float, default=180.0, help="simulated time of a run")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time")
    options = parser.parse_args(arguments)
    console = Console(emoji=False)
    wanted = {
        step_s: [scenario(step_s, seed, options.seconds) for seed in range(1, 1 + options.seeds)] for step_s in STEPS_S
    }
    options.out.mkdir(parents=True, exist_ok=True)
    runs = [one for some in wanted.values() for one in some]
    with display(Console(stderr=True, emoji=False), len(runs)) as bar:
        outcome = run_scenarios(runs, options.out, options.jobs, bar)
    for failure in outcome.failures:
        console.print(f"{failure.scenario}: {failure.sentence}", markup=False)
    if outcome.failures or outcome.interrupted:
        return 1
    measured = table({step_s: [options.out / one.name for one in some] for step_s, some in wanted.items()})
    measured.to_csv(options.out / "steps.csv", index=False)
    show(measured, console)
    shorter = measured[measured["step_s"] != STEPS_S[0]]
    console.print(f"{len(apart(shorter, measured))} of {len(shorter)} intervals do not meet that of {STEPS_S[0]} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
