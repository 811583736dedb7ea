"""Consistency of the filters: NIS and NEES on honest traffic, for every profile."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from gpsec.core.progress import Progress, Report
from gpsec.outcomes.digests import DIGESTS, table_digests
from gpsec.outcomes.tables import FLOAT_FORMAT, whole
from gpsec.pipeline.consistency import measure_consistency
from gpsec.pipeline.fingerprint import fingerprint
from gpsec.scenario import Scenario
from gpsec.types.constants import MANIFEST

TABLE = "consistency.csv"


def evaluate(scenario: Scenario, folder: Path, report: Report) -> None:
    """Run a scenario of one profile without attacks and write `TABLE` into `folder`."""
    report(Progress(scenario.name, stage="comparing errors with covariances"))
    (profile,) = scenario.fleet.profile
    found = measure_consistency(scenario, profile, scenario.duration_s or 0.0)
    rows = [
        {"profile": profile, "filter": name, "quantity": quantity} | asdict(each) | {"consistent": each.consistent}
        for (name, quantity), each in found.items()
    ]
    with whole(folder / TABLE) as partial:
        pd.DataFrame(rows).rename(columns={"freedom": "expected"}).to_csv(
            partial, index=False, float_format=FLOAT_FORMAT, lineterminator="\n", encoding="utf-8"
        )
    with whole(folder / MANIFEST) as partial:
        stated = {
            "fingerprint": fingerprint(scenario),
            "configuration": scenario.stated(),
            DIGESTS: table_digests(folder, [Path(TABLE).stem]),
        }
        partial.write_text(json.dumps(stated, indent=1) + "\n", encoding="utf-8")


def gather(folders: Sequence[Path]) -> pd.DataFrame:
    """Return the tables of several runs as one."""
    return pd.concat([pd.read_csv(folder / TABLE) for folder in folders], ignore_index=True)
