"""What attackers who know the defence come to, detector by detector: ``python -m benchmarks.impact``.

Runs networks with several seeds, in which every vehicle is attacked: by who does not know the defence, by who moves
fixes only where cameras are blind, by who is patient, and, for every detector at every rate, by who knows it, holding
or moving the fix inside junctions. Sets how far the undefended estimate gets before the first alarm (`impact.csv`)
beside the false alarms that were achieved. What has been run is not run again.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from rich.console import Console
from rich.table import Table

import gpsec
from benchmarks.city import ROOT
from gpsec.attacks.plans import PlanConfig, plan_config
from gpsec.console.bars import display
from gpsec.report.formatting import figure, interval
from gpsec.running.seeds import parse_seeds
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.types.points import point_name

NETWORKS = ("town", "sharp_turns", "highway")
DETECTORS = ("chi_square", "cusum", "isolation_forest", "lstm_glr", "innovation", "joint", "separation")
RATES = ("0.1/h", "1/h", "1e-3/sample")
RESPONSE = "ukf5_rollback"
SLOW_MPS = (0.004, 0.015, 0.06)
WHEN = {"share": 1.0, "start_after_s": [0.0, 10.0], "duration_s": [60.0, 60.0]}
# The patient attacker's time is what a vehicle takes through the network.
PATIENT = {"share": 1.0, "start_after_s": [0.0, 0.0], "duration_s": [600.0, 600.0]}


def plans(detectors: Sequence[str], rates: Sequence[str]) -> list[PlanConfig]:
    """Return the attackers: fixed, blind and patient ones, and those of each operating point."""
    tables: list[dict[str, object]] = [
        {"attack": "stealth", "name": "fixed", **WHEN},
        {"attack": "blind_drift", "name": "blind", "rate_mps": 1.0, **WHEN},
        *({"attack": "drift", "name": f"patient_{rate:g}", "rate_mps": rate, **PATIENT} for rate in SLOW_MPS),
    ]
    for detector in detectors:
        for rate in rates:
            point = point_name(detector, rate)
            for junctions in ("hold", "move"):
                name = f"{point}_{junctions}"
                tables.append({"attack": "adaptive", "name": name, "target": point, "junctions": junctions, **WHEN})
    return [plan_config(table, "impact") for table in tables]


def scenario(network: str, duration_s: float, detectors: Sequence[str], rates: Sequence[str]) -> Scenario:
    """Return a network under all attackers, with a defence for every operating point."""
    found = load_scenario(ROOT / "scenarios" / network)
    defences = [Defence(detector=name, response=RESPONSE, rate=rate) for name in detectors for rate in rates]
    changes = {
        "duration_s": duration_s,
        "detection": found.detection.model_copy(update={"detectors": tuple(detectors), "rates": tuple(rates)}),
        "defences": (Defence(detector="never", response="none"), *defences),
        "plans": tuple(plans(detectors, rates)),
        "outcomes": found.outcomes.model_copy(update={"bootstrap": 100}),
    }
    return found.model_copy(update=changes)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what has not been run yet, and show what came of it; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.impact", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "impact", help="folder of the runs")
    parser.add_argument("--network", action="append", metavar="NAME", help=f"default: {', '.join(NETWORKS)}")
    parser.add_argument("--detector", action="append", metavar="NAME", help="default: all")
    parser.add_argument("--rate", action="append", metavar="RATE", help=f"default: {', '.join(RATES)}")
    parser.add_argument("--seeds", default="1-5", metavar="A-B")
    parser.add_argument("--seconds", type=float, default=180.0, help="simulated time of a run")
    options = parser.parse_args(arguments)
    detectors, rates = options.detector or DETECTORS, options.rate or RATES
    for network in options.network or NETWORKS:
        wanted = scenario(network, options.seconds, detectors, rates)
        with display(Console(stderr=True, emoji=False), len(parse_seeds(options.seeds))) as bar:
            found = gpsec.run(wanted, options.out / network, seeds=options.seeds, resume=True, report=bar)
        table = pd.read_csv(found.folder / "impact.csv")
        target = table["attack"].map(lambda name: name.rpartition("_")[0])
        own = table[(target == table["detector"]) | table["attack"].isin(["fixed", "blind"]) | (target == "patient")]
        drawn = Table(
            "detector", "attacker", "false alarms/h", "unseen (m), median", "out of lane unseen", title=network
        )
        for row in own.to_dict("records"):
            cells = [
                f"{figure(row[name], percent=share)} {interval(row, name, percent=share)}"
                for name, share in (
                    ("false_alarms_per_vehicle_hour", False),
                    ("max_undetected_deviation_median_m", False),
                    ("out_of_lane_unseen_share", True),
                )
            ]
            drawn.add_row(str(row["detector"]), str(row["attack"]), *cells)
        Console(emoji=False).print(drawn)
    return 0


if __name__ == "__main__":
    sys.exit(main())
