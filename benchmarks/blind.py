"""An attacker who moves fixes only where cameras are blind: ``python -m benchmarks.blind``.

Runs networks with junctions, in which every vehicle is attacked by `blind_drift` at several speeds, and sets the
vehicles out of their lane and those that touch a line beside the goals, for every detector with `ukf5_rollback`.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

import gpsec
from benchmarks.city import ROOT
from gpsec.attacks.plans import plan_config
from gpsec.console.bars import display
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence

DETECTORS = ("chi_square", "cusum", "isolation_forest", "lstm_glr", "innovation", "joint", "separation")
RATE, RESPONSE = "0.1/h", "ukf5_rollback"
SPEEDS_MPS, PLAN = (0.05, 0.1, 0.3, 1.0), "blind_"
WHEN = {"share": 1.0, "start_after_s": [0.0, 0.0], "duration_s": [60.0, 60.0]}
# Largest shares of vehicles; they are goals of `joint`.
GOALS = {"out_of_lane": 0.01, "line_touched": 0.15}


def scenario(network: str, duration_s: float, seed: int) -> Scenario:
    """Return a network in which every vehicle is attacked where its camera is blind."""
    found = load_scenario(ROOT / "scenarios" / network)
    attacks = [{"attack": "blind_drift", "name": f"{PLAN}{v:g}", "rate_mps": v, **WHEN} for v in SPEEDS_MPS]
    changes = {
        "seed": seed,
        "duration_s": duration_s,
        "detection": found.detection.model_copy(update={"detectors": DETECTORS, "rates": (RATE,)}),
        "defences": (
            Defence(detector="never", response="none"),
            *(Defence(detector=name, response=RESPONSE, rate=RATE) for name in DETECTORS),
        ),
        "plans": tuple(plan_config(attack, "blind") for attack in attacks),
        "outcomes": found.outcomes.model_copy(update={"bootstrap": 10}),
    }
    return found.model_copy(update=changes)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what has not been run yet, and show what came of it; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "blind", help="folder of the runs")
    parser.add_argument("--network", default="town", metavar="NAME")
    parser.add_argument("--seed", type=int, default=2, metavar="N")
    parser.add_argument("--seconds", type=float, default=300.0, help="simulated time")
    options = parser.parse_args(arguments)
    wanted = scenario(options.network, options.seconds, options.seed)
    with display(Console(stderr=True, emoji=False), 1) as bar:
        found = gpsec.run(wanted, options.out / options.network, resume=True, report=bar)
    # Beside the plans, the network has zones; and of a receiver with metres of error, outcomes say nothing.
    ours = found.safety["attack"].str.startswith(PLAN) & found.safety["out_of_lane"].notna()
    drawn = Table(
        "profile", "attack", "detector", "vehicles", *(f"{what} (at most {most:g})" for what, most in GOALS.items())
    )
    for row in found.safety[ours].itertuples():
        shares = (f"{getattr(row, what) / row.n_vehicles:.3f}" for what in GOALS)
        drawn.add_row(
            str(row.profile), str(row.attack), str(row.defence).partition("+")[0], str(row.n_vehicles), *shares
        )
    Console(emoji=False).print(drawn)
    return 0


if __name__ == "__main__":
    sys.exit(main())
