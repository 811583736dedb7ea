"""Pictures beside the tables: traces of single vehicles, and sweeps over δ, direction, place and false-alarm rate."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from gpsec.paper import contexts, pool, vehicle
from gpsec.paper.design import (
    CONSTANT_BIAS,
    CONSUMER_BIASES_M,
    CROWDED,
    CURVE_DELTAS,
    DIRECTIONS_DEG,
    FURTHER_RATES,
    LANE_ALIAS,
    PAPER,
    SET_UPS,
    SLOW_STEALTH,
    STEALTH,
)
from gpsec.paper.plotting import LINE_COLOURS, Axes, canvas, draw_curve
from gpsec.paper.pool import Estimate
from gpsec.paper.runs import Runs
from gpsec.paper.tables import scored
from gpsec.scenario.choices import BOUNDS
from gpsec.types.constants import MODELLED, UNDEFENDED
from gpsec.types.points import PER_SAMPLE

_DELTA_TICKS = (1.05, 1.2, 1.5, 2.0)
# Where no false alarm is drawn on a logarithmic axis.
_FEWEST = 0.02


def draw_figures(runs: Runs, folder: Path) -> dict[str, str]:
    """Draw every figure into `folder`; return file name -> what it shows."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = {}
    for profile, network in SET_UPS.items():
        drawn[f"statistic_{profile}.png"] = (
            f"Residual and the detectors' statistics of one vehicle, {profile} on {network} (the paper's Figure 5)."
        )
        vehicle.statistics(runs.one("logged", profile), STEALTH, folder / f"statistic_{profile}.png")
        drawn[f"trajectory_{profile}.png"] = (
            f"Estimated and true path of one vehicle, {profile} on {network} (the paper's Figures 6-8)."
        )
        vehicle.trajectory(runs.one("logged", profile), CONSTANT_BIAS, folder / f"trajectory_{profile}.png")
    for name, (caption, draw_one) in _COMPARISONS.items():
        draw_one(runs, folder / name)
        drawn[name] = caption
    return drawn


def _delta(runs: Runs, path: Path) -> None:
    with canvas(path, 3, len(SET_UPS)) as axes:
        for column, profile in enumerate(SET_UPS):
            events = pool.read_runs(runs.of("curves", profile), "events")
            plans = [f"stealth_{delta:g}" for delta in CURVE_DELTAS]
            for name in scored(events):
                found = [pool.detection(pool.of_detector(events, name, plan)) for plan in plans]
                draw_curve(axes[0, column], CURVE_DELTAS, [each["f1"] for each in found], name)
                draw_curve(axes[1, column], CURVE_DELTAS, [each["delay_mean_s"] for each in found], name)
            for defence in (UNDEFENDED, *_responses(events)):
                left = [pool.localization(pool.of_defence(events, defence, plan))["rmse_xy_m"] for plan in plans]
                draw_curve(axes[2, column], CURVE_DELTAS, left, defence)
            axes[0, column].set_title(f"{profile}, δ pinned at {runs.pinned.delta[profile]:g}")
            for row in range(3):
                one = axes[row, column]
                one.axvline(runs.pinned.delta[profile], color="0.6", linestyle=":")
                one.set_xscale("log")
                one.set_xticks(_DELTA_TICKS, [f"{delta:g}" for delta in _DELTA_TICKS])
                one.minorticks_off()
            axes[2, column].set_xlabel("δ per 0.1 s")
        _label(axes, ("F1", "mean delay (s)", "RMSE xy (m)"))


def _direction(runs: Runs, path: Path) -> None:
    with canvas(path, 2, len(SET_UPS)) as axes:
        for column, profile in enumerate(SET_UPS):
            events = pool.read_runs(runs.of("curves", profile), "events")
            plans = [f"direction_{degrees:g}" for degrees in DIRECTIONS_DEG]
            for name in scored(events):
                found = [pool.detection(pool.of_detector(events, name, plan))["recall"] for plan in plans]
                draw_curve(axes[0, column], DIRECTIONS_DEG, found, name)
            for defence in (UNDEFENDED, "+".join(PAPER)):
                mine = [pool.localization(pool.of_defence(events, defence, plan)) for plan in plans]
                for kind, line in (("cross", "-"), ("along", "--")):
                    errors = [each[f"rmse_{kind}_track_m"] for each in mine]
                    draw_curve(axes[1, column], DIRECTIONS_DEG, errors, f"{defence}, {kind}-track", line)
            axes[0, column].set_title(f"{profile}, bias {runs.pinned.bias_m[profile]:g} m")
            axes[1, column].set_xlabel("direction from the lane's (°)")
        _label(axes, ("recall", "RMSE (m)"))


def _alias(runs: Runs, path: Path) -> None:
    with canvas(path, 2, len(CROWDED)) as axes:
        for column, network in enumerate(CROWDED):
            for place, association in enumerate(MODELLED):
                events = pool.read_runs(runs.of("mixed", association, network), "events")
                detected, left = {}, {}
                for profile in SET_UPS:
                    mine = events[events["profile"] == profile]
                    detected[profile] = pool.detection(pool.of_detector(mine, PAPER[0], LANE_ALIAS))["recall"]
                    attacked = pool.of_defence(mine, "+".join(PAPER), LANE_ALIAS)
                    out = attacked["outcome"].isin(["out_of_lane", "wrong_way", "off_road"])
                    left[profile] = pool.share(attacked, out)
                _bars(axes[0, column], detected, place, len(MODELLED), association)
                _bars(axes[1, column], left, place, len(MODELLED), association)
            axes[0, column].set_title(network)
        _label(axes, (f"recall, {PAPER[0]}", f"out of lane, {'+'.join(PAPER)}"))


def _consumer(runs: Runs, path: Path) -> None:
    events = pool.read_runs(runs.of("consumer"), "events")
    plans = {f"{bias:g} m": f"constant_{bias:g}" for bias in CONSUMER_BIASES_M} | {"stealth 1.05": SLOW_STEALTH}
    with canvas(path, 1, 2) as axes:
        names = scored(events)
        for place, name in enumerate(names):
            found = {label: pool.detection(pool.of_detector(events, name, plan)) for label, plan in plans.items()}
            for column, metric in enumerate(("recall", "delay_mean_s")):
                _bars(axes[0, column], {label: each[metric] for label, each in found.items()}, place, len(names), name)
        axes[0, 0].set_ylabel("recall")
        axes[0, 1].set_ylabel("mean delay (s)")


def _places(runs: Runs, path: Path) -> None:
    with canvas(path, 1, 2) as axes:
        for column, attack in enumerate((CONSTANT_BIAS, STEALTH)):
            found = contexts.recall_by_context(runs.one("places"), attack)
            for place, (name, by_context) in enumerate(found.items()):
                _bars(axes[0, column], by_context, place, len(found), name)
            axes[0, column].set_title(attack)
        axes[0, 0].set_ylabel("share of attacked steps in alarm")


def _rates(runs: Runs, path: Path) -> None:
    attacks = (CONSTANT_BIAS, STEALTH, SLOW_STEALTH)
    with canvas(path, len(attacks), len(SET_UPS)) as axes:
        for column, profile in enumerate(SET_UPS):
            points: dict[str, dict[str, list[tuple[float, float]]]] = {}
            for rate in (PER_SAMPLE, *FURTHER_RATES):
                folders = runs.of("main", profile) if rate == PER_SAMPLE else runs.of("rate", profile, rate)
                events, vehicles = pool.read_runs(folders, "events"), pool.read_runs(folders, "vehicles")
                for name in scored(events):
                    alarms = pool.false_alarms(vehicles, name)
                    for attack in attacks:
                        delay = pool.of_detector(events, name, attack)["detection_delay_s"].median()
                        if alarms.value is not None and np.isfinite(delay):
                            points.setdefault(attack, {}).setdefault(name, []).append((alarms.value, float(delay)))
            for row, attack in enumerate(attacks):
                for name, line in points.get(attack, {}).items():
                    x, y = np.array(sorted(line)).T
                    axes[row, column].plot(
                        np.maximum(x, _FEWEST), y, "o-", color=LINE_COLOURS(name), label=name, markersize=3
                    )
                axes[row, column].set_xscale("log")
                axes[row, column].set_title(f"{profile}, {attack}")
            axes[-1, column].set_xlabel(f"false alarms per vehicle-hour (none at {_FEWEST:g})")
        _label(axes, ["median delay (s)"] * len(attacks))


def _roc(runs: Runs, path: Path) -> None:
    _curves(runs, path, ("false_positive_rate", "recall"), log=True)


def _precision_recall(runs: Runs, path: Path) -> None:
    _curves(runs, path, ("recall", "precision"), log=False)


def _curves(runs: Runs, path: Path, columns: tuple[str, str], *, log: bool) -> None:
    attacks = (CONSTANT_BIAS, STEALTH, SLOW_STEALTH)
    with canvas(path, len(attacks), len(SET_UPS)) as axes:
        for column, profile in enumerate(SET_UPS):
            table = pool.read_runs(runs.of("main", profile)[:1], "curves")
            for row, attack in enumerate(attacks):
                one = axes[row, column]
                for name in (name for name in table["detector"].unique() if name not in BOUNDS):
                    line = table[(table["attack"] == attack) & (table["detector"] == name)]
                    one.plot(line[columns[0]], line[columns[1]], color=LINE_COLOURS(name), label=name, linewidth=1.2)
                one.set_title(f"{profile}, {attack}")
                if log:
                    one.set_xscale("log")
                    one.set_xlim(1e-4, 1.0)
                else:
                    one.set_ylim(0.8, 1.005)
            axes[-1, column].set_xlabel(columns[0].replace("_", " "))
        _label(axes, [columns[1]] * len(attacks))


_COMPARISONS: dict[str, tuple[str, Callable[[Runs, Path], None]]] = {
    "delta.png": ("Stealth against its growth δ: F1, mean delay, and the error that is left.", _delta),
    "direction.png": ("Constant bias against its direction (0 is along the lane).", _direction),
    "alias.png": ("A bias of one lane width, with nearest and with tracked matching.", _alias),
    "consumer.png": ("Consumer receivers, whose own error is metres.", _consumer),
    "places.png": ("Recall in junctions and beside lane changes, in a town.", _places),
    "roc.png": ("ROC of the statistics: how γ, the threshold, trades recall for false alarms.", _roc),
    "precision_recall.png": ("Precision and recall over all thresholds.", _precision_recall),
    "rates.png": ("False alarms for each vehicle-hour against the median delay.", _rates),
}


def _responses(events: pd.DataFrame) -> list[str]:
    return [name for name in events["defence"].unique() if name.startswith(f"{PAPER[0]}+")]


def _bars(axes: Axes, values: Mapping[str, Estimate], place: int, of: int, label: str) -> None:
    """Draw the bars of one series, the one at `place` of so many that stand side by side."""
    width = 0.8 / of
    at = np.arange(len(values)) + place * width
    height = [each.value or 0.0 for each in values.values()]
    low = [max((each.value or 0.0) - (each.low or 0.0), 0.0) for each in values.values()]
    high = [max((each.high or 0.0) - (each.value or 0.0), 0.0) for each in values.values()]
    axes.bar(at, height, width, yerr=[low, high], label=label, color=LINE_COLOURS(label), error_kw={"linewidth": 0.8})
    axes.set_xticks(np.arange(len(values)), list(values))


def _label(axes: Any, names: Sequence[str]) -> None:
    for row, name in enumerate(names):
        axes[row, 0].set_ylabel(name)
