"""Shows the trace of one vehicle on the terminal."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from rich import box
from rich.table import Table
from rich.text import Text

from gpsec.report.formatting import EMPTY, figure
from gpsec.report.stories import Story
from gpsec.running.results import Results

_LEVELS = "▁▂▃▄▅▆▇█"
_WIDTH = 56


def facts(run: Results, story: Story) -> list[tuple[str, dict[str, str]]]:
    """Return the results of the attack under each defence: (defence, heading -> text)."""
    made = []
    for row in story.events.to_dict("records"):
        outcome = row["outcome"].replace("_", " ")
        if pd.notna(row["time_to_outcome_s"]):
            outcome += f" after {row['time_to_outcome_s']:.1f} s"
        seen = "not seen"
        if row["detected"]:
            seen = f"after {row['detection_delay_s']:.1f} s" + (", alarm stood" if row["in_alarm_at_start"] else "")
        made.append(
            (
                str(row["defence"]),
                {
                    "seen": seen,
                    "GNSS not used": figure(row["isolated_share"], percent=True),
                    "largest error across (m)": figure(row["max_cross_track_m"]),
                    "RMSE (m)": figure(row["rmse_xy_m"]),
                    "would have": outcome,
                },
            )
        )
    return made


def story_parts(run: Results, story: Story, rows: pd.DataFrame) -> Iterator[Text | Table]:
    """Yield what `gpsec trace` prints: a title, a table of the defences, and curves."""
    attacked = story.attack != "none"
    what = f"under {story.attack} from {story.start_s:.1f} to {story.end_s:.1f} s" if attacked else "without an attack"
    yield Text(f"{story.vehicle_id} ({story.group}), {what}", style="bold")
    found = facts(run, story)
    if found:
        table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0))
        for name in ("defence", *found[0][1]):
            table.add_column(name, justify="left" if name == "defence" else "right", no_wrap=name == "defence")
        for defence, cells in found:
            table.add_row(defence, *cells.values())
        yield table
    time = rows["time_s"].to_numpy()
    yield Text(f"\n{time[0]:.1f} to {time[-1]:.1f} s" + ("; ^ under attack" if attacked else ""), style="italic")
    errors = _errors(rows)
    residual_m = rows["residual_m"].abs().to_numpy()
    top_m = max(float(np.nanmax(values, initial=0.0)) for values in (residual_m, *errors.values()))
    lines = {"residual": _curve(residual_m, top_m)}
    for name in [str(column) for column in rows if str(column).endswith("_alarm")]:
        alarms = rows[name].to_numpy(np.float64)
        if alarms.any():
            lines[f"{name.removesuffix('_alarm')} alarm"] = _flags(alarms)
    lines |= {defence: _curve(values, top_m) for defence, values in errors.items()}
    if attacked:
        lines[""] = _flags(rows["attacked"].to_numpy(np.float64)).replace("█", "^")
    width = max(map(len, lines))
    for name, line in lines.items():
        yield Text(f"{name:>{width}} {line}")


def _errors(rows: pd.DataFrame) -> dict[str, np.ndarray]:
    """Return the distance of each defence's estimate from the truth."""
    names = [str(column).removesuffix("_isolated") for column in rows if str(column).endswith("_isolated")]
    found = {}
    for name in names:
        away = rows[[f"{name}_x_m", f"{name}_y_m"]].to_numpy() - rows[["x_m", "y_m"]].to_numpy()
        found[name] = np.hypot(away[:, 0], away[:, 1])
    return found


def _curve(values: np.ndarray, top: float) -> str:
    """Return a line of blocks as high as values, `top` the highest, and the largest value; gaps stay empty."""
    known = np.isfinite(values)
    if not known.any():
        return EMPTY
    largest = float(np.max(values[known]))
    parts = [part[np.isfinite(part)] for part in np.array_split(values, min(_WIDTH, len(values)))]
    heights = [
        -1 if not len(part) else round(float(part.max()) / max(top, 1e-9) * (len(_LEVELS) - 1)) for part in parts
    ]
    return "".join(" " if height < 0 else _LEVELS[height] for height in heights) + f" {largest:.2f} m"


def _flags(values: np.ndarray) -> str:
    return "".join("█" if part.any() else "·" for part in np.array_split(values, min(_WIDTH, len(values))))
