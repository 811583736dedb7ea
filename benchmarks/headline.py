"""Print the first table of the README from a run: `python -m benchmarks.headline results/fleet-eval`."""

import sys
from collections.abc import Hashable
from pathlib import Path

import pandas as pd

ATTACKS = {"constant_bias": "constant bias", "stealth": "stealth", "replay": "replay"}
DETECTORS = ("lstm_glr", "joint")
DEFENCES = ("never+none", "lstm_glr+ukf", "joint+ukf5_rollback", "never+gate")
KEYS = ["scenario", "profile", "attack"]


def main() -> None:
    """Print rows of Markdown, and what false alarms the detectors had."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/fleet-eval")
    detection, safety, localization = (
        pd.read_csv(folder / f"{name}.csv", keep_default_na=False, na_values=[""])
        for name in ("detection", "safety", "localization")
    )
    detection = detection[detection.rate == "0.1/h"]
    of_detector = detection.set_index([*KEYS, "detector"]).to_dict("index")
    lost = safety.set_index([*KEYS, "defence"]).to_dict("index")
    error = localization.set_index([*KEYS, "defence"]).rmse_xy_m.to_dict()
    for scenario, profile in detection[["scenario", "profile"]].drop_duplicates().itertuples(index=False):
        if pd.isna(lost[scenario, profile, "stealth", DEFENCES[0]]["out_of_lane"]):
            continue  # most honest vehicles touch a line, so that outcomes say nothing
        for attack, name in ATTACKS.items():
            key = (scenario, profile, attack)
            seen = (_seen(of_detector[*key, detector]) for detector in DETECTORS)
            kept = (f"{_metres(error[*key, one])} m, {lost[*key, one]['out_of_lane']:.0f}" for one in DEFENCES)
            vehicles = lost[*key, DEFENCES[0]]["n_vehicles"]
            road = f"{scenario}, {profile}" if attack == "constant_bias" else ""
            print("| " + " | ".join([road, f"{name} ({vehicles:.0f})", *seen, *kept]).strip() + " |")
    benign = detection[detection.attack == "none"]
    print()
    print(benign[["scenario", "detector", "false_alarms_per_vehicle_hour", "vehicle_hours"]].to_string(index=False))


def _metres(value: float) -> str:
    return f"{value:.2f}" if value < 10.0 else f"{value:.0f}"


def _seen(row: dict[Hashable, float]) -> str:
    return f"{row['f1']:.2f}, {row['delay_mean_s']:.2g} s"


if __name__ == "__main__":
    main()
