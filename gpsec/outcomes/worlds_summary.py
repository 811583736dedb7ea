"""Prints what attacks do to the traffic of a closed loop: a line for each scenario, world and defence."""

from pathlib import Path
from typing import Any

import pandas as pd
from rich import box
from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from gpsec.outcomes.effects import BENIGN_PLAN
from gpsec.outcomes.naming import scenario_of_world
from gpsec.outcomes.tables import EFFECTS, read_table

_EMPTY = "–"
# Column of the effects, heading, digits.
_SHOWN = (
    ("collisions_per_1000_vkm", "collisions /1000 km", 1),
    ("delay_s", "delay s", 1),
    ("standing_share", "standing", 3),
    ("mean_speed_mps", "speed m/s", 2),
    ("arrived", "arrivals", 1),
)
_KEY = ("scenario", "plan", "defence", "on_alarm")


def print_worlds(out: Path, console: Console) -> None:
    """Print the effects in the folder `out`, and how many vehicles each world attacked and displaced."""
    effects, worlds = read_table(out, EFFECTS), read_table(out, "worlds")
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), show_edge=False)
    for heading in ("scenario", "attack", "defence", "on alarm", "seeds", "attacked", "out of lane"):
        table.add_column(Text(heading), justify="right" if heading in ("seeds", "attacked", "out of lane") else "left")
    for _, heading, _ in _SHOWN:
        table.add_column(Text(heading), justify="right")
    worlds = worlds.assign(scenario=[scenario_of_world(name) for name in worlds["scenario"]])
    sums = worlds.groupby([*_KEY, "false_alarms_per_h"])[["attacked", "out_of_lane"]].sum()
    for row in effects.to_dict("records"):
        key, rate = [row[name] for name in _KEY], row["false_alarms_per_h"]
        counts = [str(int(value)) for value in sums.loc[(*key, rate)]]
        if rate > 0.0:
            key[1] = f"{rate:g} false alarms /h" + (f", {key[1]}" if key[1] != BENIGN_PLAN else "")
        cells = [*key, str(row["seeds"]), *counts, *(_cell(row, name, digits) for name, _, digits in _SHOWN)]
        table.add_row(*(Text(cell) for cell in cells))
    benign = worlds[worlds["plan"] == BENIGN_PLAN]
    title = Text("What attacks do to the traffic: world less benign twin of the same seed", style="bold")
    said = "mean and interval over seeds; the twins are in effects.csv"
    if int(benign["collisions"].sum()):
        said += f"; benign worlds have {int(benign['collisions'].sum())} collisions"
    console.print(Group(title, table, Text(said, style="italic")))


def _cell(row: dict[Any, Any], name: str, digits: int) -> str:
    """Return a figure with its sign and, where there is one, its interval."""
    values = [row[name], row[f"{name}_low"], row[f"{name}_high"]]
    mean, low, high = (_EMPTY if pd.isna(value) else f"{value:+.{digits}f}" for value in values)
    return mean if low == _EMPTY else f"{mean} [{low}, {high}]"
