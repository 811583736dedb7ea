"""Reads what a run has written, for what is printed of it: of a scenario with several seeds, what is over all."""

import json
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.tables import POOLED_PREFIX, read_table
from gpsec.types.constants import MANIFEST


def read_manifests(out: Path) -> list[dict[str, Any]]:
    """Return the manifest of each scenario of the run in `out`."""
    manifest = json.loads((out / MANIFEST).read_text("utf-8"))
    found: list[dict[str, Any]] = manifest.get("scenarios", [manifest])
    return found


def bootstrap_of(stated: dict[str, Any]) -> Bootstrap:
    """Return how intervals of a run are made, from the manifest of one of its scenarios; a former one tells less."""
    given = stated.get("configuration", {}).get("outcomes", {})
    return Bootstrap(stated.get("seed", 0), given.get("bootstrap", 1000), given.get("confidence", 0.95))


def read_pooled(out: Path, name: str) -> pd.DataFrame:
    """Return a table of the run; of a scenario with several seeds, the rows over all of them."""
    table = read_table(out, name)
    if not (out / f"{POOLED_PREFIX}{name}.csv").is_file():
        return table
    pooled = read_table(out, f"{POOLED_PREFIX}{name}")
    alone = table[~table["scenario"].map(base_name).isin(pooled["scenario"])]
    return pd.concat([pooled, alone], ignore_index=True)
