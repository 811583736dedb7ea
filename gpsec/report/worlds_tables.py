"""What attacks do to traffic, as a table, sentences and figures: attack × defence × reaction."""

from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd

from gpsec.outcomes.effects import BENIGN_PLAN, WORLD_KEY, mean_interval, with_collision_rates
from gpsec.report.figure_data import Figure, Series, colours
from gpsec.report.formatting import EMPTY
from gpsec.report.tables import ReportTable, TableCell, TableRow
from gpsec.report.worlds_names import INJECTED, attack_name, by_world, where, world_label
from gpsec.running.results import Results
from gpsec.scenario.closed_loop import DRIVE_ON
from gpsec.types.constants import UNDEFENDED

# Of each measure: heading, decimals, and how it is said that there is more of it.
_TITLES = {
    "collisions_per_1000_vkm": ("collisions per 1,000 km", 1),
    "standing_share": ("standing share", 3),
    "delay_s": ("delay of a vehicle (s)", 1),
    "arrived": ("arrivals", 1),
    "mean_speed_mps": ("mean speed (m/s)", 2),
}
_IN_TABLE = ("collisions_per_1000_vkm", "standing_share", "delay_s", "arrived")
_FEW_SEEDS = 10


def effect_tables(run: Results) -> list[ReportTable]:
    """Return the table of each scenario: what each world came to, and its difference to the benign twin."""
    rows: dict[str, list[TableRow]] = {}
    effects = _effects(run)
    for world, worlds in by_world(with_collision_rates(run.worlds["worlds"])):
        cells = [TableCell(str(world["on_alarm"])), TableCell(str(len(worlds)))]
        cells += [TableCell(f"{worlds[name].sum():.0f}") for name in ("attacked", "out_of_lane")]
        effect = effects.get(tuple(world[name] for name in WORLD_KEY))
        for name in _IN_TABLE:
            digits = _TITLES[name][1]
            values = worlds[name].to_numpy(float)
            cells.append(TableCell(f"{values.mean():.{digits}f}", _range(*mean_interval(values), digits)))
            cells.append(_difference(effect, name))
        name = str(world["defence"])
        if world["false_alarms_per_h"] > 0.0:
            name += f" ({world['false_alarms_per_h']:g} an hour)"
        rows.setdefault(str(world["scenario"]), []).append(TableRow(attack_name(world), name, cells))
    headings = ["attack", "defence", "on alarm", "seeds", "attacked", "out of lane"]
    for name in _IN_TABLE:
        headings += [_TITLES[name][0], "difference"]
    caption = (
        "Means over the seeds, and the difference to the twins: benign worlds of the same seed, defence and reaction."
        " Small print: interval of 95 % by bootstrap over the seeds. Attacked and out of lane (truly, not as the open"
        " loop would have it) are sums over the seeds."
    )
    return [ReportTable(group, headings, lines, caption) for group, lines in rows.items()]


def _effects(run: Results) -> dict[tuple[Any, ...], dict[Any, Any]]:
    found = run.worlds["effects"].to_dict("records")
    return {tuple(row[name] for name in WORLD_KEY): row for row in found}


def _difference(effect: dict[Any, Any] | None, name: str) -> TableCell:
    if effect is None or pd.isna(effect[name]):
        return TableCell(EMPTY)
    digits = _TITLES[name][1]
    return TableCell(_signed(effect[name], digits), _range(effect[f"{name}_low"], effect[f"{name}_high"], digits))


def _signed(value: float, digits: int) -> str:
    text = f"{value:+.{digits}f}"
    return text[1:] if float(text) == 0.0 else text


def _range(low: float, high: float, digits: int) -> str:
    if pd.isna(low) or pd.isna(high):
        return ""
    return f"{_plain(low, digits)} to {_plain(high, digits)}"


def _plain(value: float, digits: int) -> str:
    return f"{value:.{digits}f}".replace(f"-{0:.{digits}f}", f"{0:.{digits}f}")


def sentences(run: Results) -> dict[str, list[str]]:
    """Return scenario -> what attacks did there, in plain words: the worst and the best world of each attack."""
    said: dict[str, list[str]] = {}
    effects = run.worlds["effects"]
    effects = effects.assign(attack=[attack_name(row) for row in effects.to_dict("records")])
    for (scenario, _), rows in effects.groupby(["scenario", "attack"], sort=False):
        ordered = rows.sort_values("collisions_per_1000_vkm", ascending=False, kind="stable").to_dict("records")
        ends = [ordered[0], ordered[-1]] if len(ordered) > 1 else ordered
        said.setdefault(str(scenario), []).extend(_sentence(row) for row in ends if row["seeds"] > 0)
    for group, lines in said.items():
        seeds = int(effects.loc[effects["scenario"] == group, "seeds"].max())
        if seeds < _FEW_SEEDS:
            few = "one seed is" if seeds == 1 else f"{seeds} seeds are"
            lines.append(f"These are differences to benign twins; {few} a first look, claims need {_FEW_SEEDS}.")
    return said


def _sentence(row: dict[Any, Any]) -> str:
    whose = "undefended" if row["defence"] == UNDEFENDED else f"with {row['defence']}"
    if row["on_alarm"] != DRIVE_ON and row["defence"] != UNDEFENDED:
        whose += f" that lets vehicles {row['on_alarm'].replace('_', ' ')}"
    if row["false_alarms_per_h"] > 0.0:
        whose += f", {row['false_alarms_per_h']:g} an hour"
    name = "collisions_per_1000_vkm"
    between = _range(row[f"{name}_low"], row[f"{name}_high"], 1)
    between = f" ({between})" if between else ""
    return (
        f"{row['attack']}, {whose}: {_signed(row[name], 1)} collisions per 1,000 vehicle-km{between},"
        f" {_signed(row['delay_s'], 1)} s of delay a vehicle, {_signed(100.0 * row['standing_share'], 1)} points of"
        " standing time."
    )


def effects_figure(run: Results) -> Figure:
    """Return the differences to the twins, a point for each world."""
    series = []
    rows = run.worlds["effects"].to_dict("records")
    paint = colours(dict.fromkeys(world_label(row) for row in rows))
    for name, (title, _) in _TITLES.items():
        for row in rows:
            if pd.isna(row[name]):
                continue
            label = world_label(row)
            low, high = _bounds(row, name)
            series.append(
                Series(
                    label,
                    "points",
                    [row[name]],
                    [label],
                    x_low=low,
                    x_high=high,
                    colour=paint[label],
                    where={**where(row), "figure": title},
                )
            )
    return Figure(
        "effects",
        "What the attack does to the traffic: world less twin",
        "world less benign twin",
        "",
        series,
        "There is no world with this attack, or it has no twin.",
        "Means over the seeds, with intervals of 95 %.",
        {"xaxis": {"zeroline": True, "zerolinewidth": 2}, "yaxis": {"autorange": "reversed", "type": "category"}},
    )


def _bounds(row: dict[Any, Any], name: str) -> tuple[list[float] | None, list[float] | None]:
    if pd.isna(row[f"{name}_low"]):
        return None, None
    return [row[f"{name}_low"]], [row[f"{name}_high"]]


def false_alarm_figure(run: Results) -> Figure | None:
    """Return what false alarms cost against their rate, None where none were injected."""
    effects = run.worlds["effects"]
    chosen = effects[(effects["plan"] == BENIGN_PLAN) & (effects["false_alarms_per_h"] > 0.0)]
    if chosen.empty:
        return None
    series = list(_cost_lines(chosen))
    return Figure(
        "false_alarms",
        "What false alarms cost",
        "injected false alarms a vehicle-hour",
        "difference to the world without any",
        series,
        "No false alarms were injected in this scenario.",
        "With intervals over the seeds. The rate that a detector achieves is in detection.csv.",
        {"xaxis": {"rangemode": "tozero"}, "yaxis": {"zeroline": True, "zerolinewidth": 2}},
    )


def _cost_lines(chosen: pd.DataFrame) -> Iterator[Series]:
    keys = ["scenario", "defence", "on_alarm"]
    paint = colours(dict.fromkeys(f"{row.defence}, {row.on_alarm}" for row in chosen.itertuples()))
    for (scenario, defence, reaction), rows in chosen.groupby(keys, sort=False):
        rows = rows.sort_values("false_alarms_per_h")
        x = [0.0, *rows["false_alarms_per_h"]]
        label = f"{defence}, {reaction}"
        for name, (title, _) in _TITLES.items():
            y, low, high = ([0.0, *rows[f"{name}{end}"]] for end in ("", "_low", "_high"))
            place = {"group": str(scenario), "attack": INJECTED, "figure": title}
            yield Series(label, "line", x, y, colour=paint[label], where=place)
            yield Series(f"{label}, interval", "points", x, y, low=low, high=high, colour=paint[label], where=place)


def attacks_of(run: Results) -> Sequence[str]:
    """Return the attacks of all worlds, without the benign twins."""
    rows = run.worlds["worlds"].to_dict("records")
    return [name for name in dict.fromkeys(attack_name(row) for row in rows) if name != BENIGN_PLAN]
