"""The data card of a dataset: what is in it, of what it was made, and how to read it."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

from pyarrow import parquet

from gpsec.paper.dataset_log import MEASURED
from gpsec.scenario import Scenario
from gpsec.sensors.profiles import residual_sigma_m
from gpsec.sensors.registry import PROFILES

_Runs = Mapping[str, Sequence[Scenario]]
_Files = Mapping[str, Sequence[Path]]
_PACKAGES = ("gpsec", "libsumo", "numpy", "numba", "pyarrow")
_SPLITS = {
    "train": "honest vehicles; the runs that gpsec's own detectors learn on",
    "calibration": "honest vehicles; the runs that gpsec's own thresholds are set on. Set yours here, not on `test`",
    "test": "honest vehicles, and tracks under attack, on networks that are in no other split",
}


def provenance_of(profile: str, runs: _Runs, files: _Files, out: Path) -> str:
    """Return what the dataset was made of, as JSON: versions, runs with their settings, digests of the files."""
    told = {
        "profile": profile,
        "versions": {package: version(package) for package in _PACKAGES},
        "runs": {
            path.relative_to(out).as_posix(): {
                "split": split,
                "seed": scenario.seed,
                "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
                "rows": parquet.read_metadata(path).num_rows,
                "plans": [plan.model_dump(mode="json") for plan in scenario.plans],
            }
            for split, members in runs.items()
            for scenario, path in zip(members, files.get(split, ()), strict=True)
        },
    }
    return json.dumps(told, indent=1) + "\n"


def card(profile: str, runs: _Runs, files: _Files) -> str:
    """Return the data card, in Markdown."""
    figures = PROFILES[profile]
    lines = [
        f"# GPS spoofing of automated vehicles: residuals, sensors, truth and labels ({profile})",
        "",
        "Synthetic: traffic of SUMO, sensors of gpsec. Nobody's journey is in it. A row is one vehicle in one step of",
        "0.1 s, honest (`attack` is `none`) or under one attack. Positions are of the rear axle, in metres east and",
        "north in the frame of the network.",
        "",
        "## Files",
        "",
        "| split | files | rows | what |",
        "|---|---|---|---|",
    ]
    for split, paths in files.items():
        rows = sum(parquet.read_metadata(path).num_rows for path in paths)
        names = ", ".join(f"`{path.stem}`" for path in paths)
        lines.append(f"| `{split}` | {names} | {rows} | {_SPLITS[split]} |")
    lines += [
        "",
        "A file is called `<network>-<seed>.parquet`; the seed is of traffic and of all noise. Networks are those of",
        "gpsec, built by it; no file of `test` is of a network of `train` or `calibration`.",
        "",
        "**A track under attack has rows from the first step of its attack on.** Before that it is the honest track of",
        "the same `vehicle`: to the last bit, so put its rows before them. After the attack the rows go on,",
        "with `attacked` false, since what a vehicle believes has been changed.",
        "",
        "## Columns",
        "",
        "| column | meaning |",
        "|---|---|",
        "| `vehicle` | name of the vehicle within the file |",
        "| `attack` | `none`, or the attack of this track (below) |",
        *(f"| `{name}` | {one.meaning} |" for name, one in MEASURED.items()),
        "",
        "A detector may use neither what is marked *truth* nor the label, nor rows of a later step. gpsec's own see",
        f"`residual_m` divided by the {residual_sigma_m(figures):.4g} m that the profile promises on a straight road.",
        "",
        "## Attacks",
        "",
        "| `attack` | settings |",
        "|---|---|",
    ]
    plans = {plan.name: plan for members in runs.values() for scenario in members for plan in scenario.plans}
    for name, plan in plans.items():
        told = {"attack": plan.attack, **plan.parameters.model_dump(mode="json"), "share": plan.share}
        told |= {"start_after_s": plan.start_after_s, "duration_s": plan.duration_s}
        lines.append(f"| `{name}` | `{json.dumps(told)}` |")
    lines += [
        "",
        "What they do is in gpsec's documentation of its attacks. None of them knows a detector: a figure from this",
        "dataset says nothing of attackers who know yours. `gpsec bench-detector` has those. `gpsec judge` sets",
        "thresholds on scores of `calibration` and counts what they do on `test`, as for its own detectors.",
        "",
        "## Provenance",
        "",
        f"Sensor profile `{profile}` ({figures.title}); the source of every figure is in gpsec's `docs/sensors.md`.",
        f"Made by `gpsec dataset` with {', '.join(f'{package} {version(package)}' for package in _PACKAGES)}. The same",
        "versions make the same bytes; `dataset.json` has the SHA-256 of each file, with its seed and attacks.",
        "",
        "Licence: none is stated. gpsec has none yet either (see its README): ask its owner before you pass this on.",
        "",
    ]
    return "\n".join(lines)
