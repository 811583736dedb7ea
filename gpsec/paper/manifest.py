"""What the tables were made from, for whoever wants to repeat them."""

import json
from pathlib import Path

from gpsec.outcomes.tables import whole
from gpsec.paper.pool import BOOTSTRAP
from gpsec.paper.runs import Runs
from gpsec.types.constants import MANIFEST

# Of the manifest of each run: what it was, not what it cost.
_KEPT = ("scenario", "seed", "fingerprint", "configuration", "steps", "vehicles", "vehicle_steps")


def write_runs(path: Path, runs: Runs) -> None:
    """Write what was pinned, how intervals were made, and the configuration of every run."""
    stated = {
        folder.name: json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        for folders in runs.groups.values()
        for folder in folders
    }
    first = next(iter(stated.values()))
    content = {
        "gpsec_version": first["gpsec_version"],
        "git_commit": first["git_commit"],
        "python_version": first["python_version"],
        "versions": first["versions"],
        "pinned": {"delta": runs.pinned.delta, "bias_m": runs.pinned.bias_m},
        "bootstrap": {"seed": BOOTSTRAP.seed, "replicates": BOOTSTRAP.replicates, "confidence": BOOTSTRAP.confidence},
        "runs": {name: {key: run[key] for key in _KEPT} for name, run in sorted(stated.items())},
    }
    with whole(path) as partial:
        partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
