"""`gpsec judge`: scores that were made without gpsec, judged as gpsec's own detectors are."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.console.errors import say

if TYPE_CHECKING:
    import pandas as pd

# Wide enough for the names of attacks and six columns of figures.
_NARROWEST = 100


def judge(
    dataset: Annotated[Path, typer.Argument(metavar="DATASET", help="What gpsec dataset has written.")],
    scores: Annotated[
        Path,
        typer.Argument(
            metavar="SCORES", help="A folder with calibration and test, and in them a file for each of the dataset's."
        ),
    ],
    name: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of the detector. [default: that of the folder SCORES]")
    ] = None,
) -> None:
    """Judge scores of a dataset at measured rates of false alarms, with the columns of detection.csv.

    Each file has the columns vehicle, attack, step and score: at least 0, the higher the more anomalous, and none
    where the detector says nothing. Thresholds are set on calibration, for alarms as rare as its hours can tell.
    SCORES/judged.csv gets a row for each file of test, attack and rate.

    \b
    Examples:
      gpsec judge spoofing ecod
      gpsec judge spoofing ecod/scores --name ecod
    """  # noqa: D301
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages
    from gpsec.outcomes.tables import whole, write_frame
    from gpsec.paper.judging import JUDGED_TABLE, judge_scores, profile_of, splits_of
    from gpsec.running.folders import resolved

    data, target = resolved(dataset), resolved(scores)
    profile, files = profile_of(data), splits_of(data)
    with display(messages(), sum(map(len, files.values()))) as show:
        table = judge_scores(files, target, name or target.name, profile, show)
    with whole(target / JUDGED_TABLE) as partial:
        write_frame(table, partial)
    _show(table)
    say(f"{target / JUDGED_TABLE}: {len(table)} rows")


def _show(table: "pd.DataFrame") -> None:
    """Show a line for each attack and rate: means over the files in which it is."""
    from rich.table import Table

    from gpsec.console.terminal import tables
    from gpsec.report.formatting import figure

    drawn = Table("attack", "rate", "false alarms/h", "precision", "recall", "F1", "delay (s)", "seen", box=None)
    attacked = table[table["n_events"] > 0]
    for (attack, rate), rows in attacked.groupby(["attack", "rate"], sort=False):
        alarms = (rows["false_alarms_per_vehicle_hour"] * rows["vehicle_hours"]).sum() / rows["vehicle_hours"].sum()
        means = rows[["precision", "recall", "f1", "delay_mean_s"]].mean()
        seen = (rows["detected_share"] * rows["n_events"]).sum() / rows["n_events"].sum()
        cells = [figure(alarms), *(figure(value) for value in means), figure(seen, percent=True)]
        drawn.add_row(str(attack), str(rate), *cells)
    tables(_NARROWEST).print(drawn)
