"""The story of one crash: where both vehicles were in the seconds before it, and where they believed to be."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import cos, nan, sin

import numpy as np
import pandas as pd

from gpsec.outcomes.effects import BENIGN_PLAN
from gpsec.outcomes.worlds import COLLISION_KINDS
from gpsec.report.figure_data import Figure, Series
from gpsec.report.worlds_names import attack_name, by_world, where, world_label
from gpsec.running.results import Results

_NO_CRASH = "There was no collision in a world with this attack."
# Colours of the two vehicles.
_COLOURS = (4, 0)
# Seen at first around the crash; the page scrolls out to the whole 20 s.
_AROUND_M = 40.0
# The bodies are drawn at the crash and so long before it.
_DRAWN_S = (0.0, 1.0, 2.0)


@dataclass(frozen=True)
class CrashStory:
    """A crash of one world.

    Attributes:
        where: under which choices it is shown.
        crash_s: simulated time of the hit.
        vehicles: rows of `crashes.csv` of both, in the order of time.
    """

    where: Mapping[str, str]
    crash_s: float
    vehicles: tuple[tuple[str, pd.DataFrame], ...]


def crash_stories(run: Results) -> Iterator[CrashStory]:
    """Yield one crash of each kind of each world: that of the first seed that has one, head-on ones first."""
    for world, rows in by_world(run.worlds["crashes"]):
        if attack_name(world) == BENIGN_PLAN:
            continue
        for kind in COLLISION_KINDS:
            mine = rows[rows["kind"] == kind]
            if mine.empty:
                continue
            mine = mine[mine["run"] == mine["run"].iloc[0]]
            crash_s, seed = float(mine["crash_s"].iloc[0]), int(mine["seed"].iloc[0])
            hit = f"{kind} at {crash_s:.1f} s with {mine['closing_mps'].iloc[0]:.1f} m/s"
            label = f"{world_label(world)}: {hit}, seed {seed}"
            vehicles = tuple(
                (str(name), one.sort_values("time_s")) for name, one in mine.groupby("vehicle_id", sort=False)
            )
            yield CrashStory({**where(world), "crash": label}, crash_s, vehicles)


def crash_figures(run: Results) -> list[Figure]:
    """Return the figures of crashes: the paths, how far both were beside their path, and their speeds."""
    stories = list(crash_stories(run))
    before = "time before the crash (s)"
    return [
        Figure(
            "crash_path",
            "Paths of both vehicles, and where they believed to be",
            "x in the net, from the crash (m)",
            "y in the net, from the crash (m)",
            [series for story in stories for series in _path(story)],
            _NO_CRASH,
            "The last 20 s, of the middle of the bodies, which are drawn at the crash and one and two seconds before."
            " Crosses are the estimate of the defence that steers; who is no part of the fleet has none. Scroll to see"
            " all of it.",
            {"xaxis": {"range": [-_AROUND_M, _AROUND_M]}, "yaxis": {"scaleanchor": "x", "range": [-25, 25]}},
            tall=True,
        ),
        Figure(
            "crash_beside",
            "How far both were beside their path, and how far off their estimate was",
            before,
            "left of the path (m)",
            [series for story in stories for series in _beside(story)],
            _NO_CRASH,
            "A vehicle that holds its estimate in the middle of its path is displaced by the error, to the other side.",
        ),
        Figure(
            "crash_speed",
            "Speeds",
            before,
            "speed (m/s)",
            [series for story in stories for series in _speeds(story)],
            _NO_CRASH,
        ),
    ]


def _path(story: CrashStory) -> Iterator[Series]:
    last = [rows.iloc[-1] for _, rows in story.vehicles]
    x0, y0 = (float(np.mean([row[f"{axis}_m"] for row in last])) for axis in "xy")
    for (name, rows), colour in zip(story.vehicles, _COLOURS, strict=False):
        x, y = rows["x_m"].to_numpy() - x0, rows["y_m"].to_numpy() - y0
        yield Series(f"{name}, truth", "line", x, y, colour=colour, where=story.where)
        known = rows[rows["estimate_x_m"].notna() & rows["estimate_y_m"].notna()]
        if len(known):
            at = known["estimate_x_m"].to_numpy() - x0, known["estimate_y_m"].to_numpy() - y0
            yield Series(f"{name}, estimate", "points", *at, colour=colour, where=story.where, mark="x-thin-open")
        moments = [int(np.argmin(np.abs(rows["time_s"].to_numpy() - (story.crash_s - ago_s)))) for ago_s in _DRAWN_S]
        bodies = np.concatenate([_corners(rows.iloc[at], x0, y0) for at in moments])
        yield Series(f"{name}, body", "area", bodies[:, 0], bodies[:, 1], colour=colour, where=story.where)


def _corners(body: "pd.Series[float]", x0: float, y0: float) -> np.ndarray:
    """Return (6, 2) corners of a body, closed, from the crash; the last one is a gap."""
    half, side, yaw = 0.5 * body["length_m"], 0.5 * body["width_m"], body["yaw_rad"]
    along = np.array([half, half, -half, -half, half])
    left = np.array([side, -side, -side, side, side])
    x = body["x_m"] - x0 + cos(yaw) * along - sin(yaw) * left
    y = body["y_m"] - y0 + sin(yaw) * along + cos(yaw) * left
    return np.append(np.stack([x, y], axis=1), [[nan, nan]], axis=0)


def _beside(story: CrashStory) -> Iterator[Series]:
    for (name, rows), colour in zip(story.vehicles, _COLOURS, strict=False):
        time = rows["time_s"].to_numpy() - story.crash_s
        attacked = time[rows["attacked"].to_numpy()]
        if len(attacked):
            span = [float(attacked[0]), float(attacked[-1])]
            yield Series(f"{name} under attack", "span", span, [0.0, 0.0], colour=colour, where=story.where)
        displaced = rows["displacement_m"].to_numpy()
        yield Series(f"{name} is", "line", time, displaced, colour=colour, where=story.where)
        off_x, off_y = (rows[f"estimate_{axis}_m"].to_numpy() - rows[f"{axis}_m"].to_numpy() for axis in "xy")
        if np.isfinite(off_x).any():
            yaw = rows["yaw_rad"].to_numpy()
            error = off_y * np.cos(yaw) - off_x * np.sin(yaw)
            yield Series(f"{name}, error of its estimate", "line", time, error, colour=colour + 6, where=story.where)


def _speeds(story: CrashStory) -> Iterator[Series]:
    for (name, rows), colour in zip(story.vehicles, _COLOURS, strict=False):
        time = rows["time_s"].to_numpy() - story.crash_s
        yield Series(name, "line", time, rows["speed_mps"].to_numpy(), colour=colour, where=story.where)
