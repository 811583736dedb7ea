"""The figures of a report, from the tables of a run."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from gpsec.outcomes.naming import base_name
from gpsec.outcomes.state import OUTCOMES
from gpsec.report.figure_data import Figure, Series, colours, group_name, grouped
from gpsec.running.results import Results
from gpsec.scenario.choices import BOUNDS
from gpsec.types.constants import UNDEFENDED

_POINTS_OF_A_DISTRIBUTION = 60
# Colours of the outcomes.
_SEVERITY = (5, 1, 4, 3)


def detectors_of(run: Results) -> list[str]:
    """Return the detectors that were compared, without the bounds."""
    return [name for name in run.detection["detector"].cat.categories if name not in BOUNDS]


def defences_of(run: Results) -> list[str]:
    """Return the defences, the undefended vehicle first."""
    return sorted(run.safety["defence"].cat.categories, key=lambda name: name != UNDEFENDED)


def delays(run: Results, over: Results | None = None) -> Figure:
    """Return the distribution of detection delays; attacks that were not detected are missing at its right end.

    `over` is the run over several seeds, whose events are taken together as well.
    """
    colour = colours(detectors_of(run))
    events = run.events.drop_duplicates(["scenario", "vehicle_id", "attack", "detector"])
    if over is not None:
        names = events["scenario"].astype(str)
        together = names.map(base_name)
        several = together.isin(over.safety["scenario"].astype(str))
        events = pd.concat([events.assign(scenario=together)[several], events.assign(scenario=names)])
    series = []
    for where, detector, rows in grouped(events[events["detector"].isin(colour)], "detector"):
        delay = rows["detection_delay_s"]
        found = np.sort(delay[~np.isnan(delay)])
        if not len(found):
            continue
        place = np.unique(
            np.linspace(0, len(found) - 1, min(len(found), _POINTS_OF_A_DISTRIBUTION)).round().astype(int)
        )
        share = (place + 1) / len(delay)
        x, y = [0.0, *found[place]], [0.0, *share]
        series.append(Series(detector, "step", x, y, colour=colour[detector], where=where))
    return Figure(
        "delay",
        "How soon attacks are seen",
        "time since the attack began (s)",
        "share of the attacks seen by then",
        series,
        "No detector that was compared saw any attack of this kind, so there are no delays.",
        "Distribution over attacked vehicles. Where a line ends below 1, the rest was not seen before the attack ended."
        " The detectors of the defences are shown.",
        {"yaxis": {"range": [0, 1.02]}},
        labelled=True,
    )


_NO_CURVE = (
    "No sample under this attack could be scored (jamming, for one, takes the fixes away), so the curve is not defined."
)


def roc(run: Results) -> Figure:
    """Return ROC curves, with the detectors as they were run; the axis of false positives is logarithmic."""
    rates = np.concatenate([table["false_positive_rate"].to_numpy(np.float64) for table in (run.curves, run.detection)])
    decade = float(np.floor(np.log10(np.min(rates[rates > 0.0], initial=1e-2))))
    lowest = 10.0**decade
    logarithmic = {"type": "log", "dtick": 1, "exponentformat": "power", "range": [decade - 0.1, 0.05]}
    return _curves(
        run,
        Axis("false_positive_rate", "false-positive rate", lowest),
        Axis("recall", "true-positive rate"),
        Figure(
            "roc",
            "Receiver operating characteristic",
            "",
            "",
            [],
            _NO_CURVE,
            "Shares of the samples that are not attacked, and that are. Lines: the statistic against any threshold."
            " Diamonds: the detector as it was run, with its threshold and its hold of alarms, which is why it may lie"
            f" off its line. Rates below {lowest:g}, and none at all, are drawn there.",
            {"xaxis": logarithmic, "yaxis": _SQUARE},
        ),
    )


def precision_recall(run: Results) -> Figure:
    """Return precision-recall curves, with the detectors as they were run."""
    return _curves(
        run,
        Axis("recall", "recall"),
        Axis("precision", "precision"),
        Figure(
            "pr",
            "Precision and recall",
            "",
            "",
            [],
            _NO_CURVE,
            "Precision depends on how much of the time is under attack; compare it within a run only."
            " Diamonds: the detector as it was run.",
            {"xaxis": _SQUARE, "yaxis": _SQUARE},
        ),
    )


_SQUARE = {"range": [-0.02, 1.02]}


@dataclass(frozen=True)
class Axis:
    """A column of `curves.csv` and `detection.csv` as an axis: its title, and what smaller values are drawn as."""

    column: str
    title: str
    lowest: float = 0.0

    def values(self, rows: Mapping[str, Any]) -> Any:
        """Return what is drawn."""
        return np.maximum(rows[self.column], self.lowest)


def _curves(run: Results, x: Axis, y: Axis, figure: Figure) -> Figure:
    colour = colours(detectors_of(run))
    series = [
        Series(detector, "line", x.values(rows), y.values(rows), colour=colour[detector], where=where)
        for where, detector, rows in grouped(run.curves[run.curves["detector"].isin(colour)], "detector")
    ]
    as_run = run.detection[run.detection["detector"].isin(colour) & (run.detection["n_events"] > 0)]
    for where, detector, rows in grouped(as_run, "detector"):
        at = x.values(rows), y.values(rows)
        if not np.isnan(at).any():
            name = f"{detector}, as run"
            paint = colour[detector]
            series.append(Series(name, "points", *at, colour=paint, where=where, mark="diamond", of=detector))
    return replace(figure, x_title=x.title, y_title=y.title, series=series)


# Areas that are nearer to 1 than this are drawn there.
_NEAREST = 1e-6


def area_missing(run: Results) -> Figure:
    """Return 1 − area under the ROC curve of each detector, on a logarithmic axis."""
    colour = colours(detectors_of(run))
    known = run.detection[run.detection["detector"].isin(colour) & run.detection["roc_auc"].notna()]
    series = []
    for where, detector, rows in grouped(known, "detector"):
        missing = 1.0 - rows["roc_auc"]
        text = [f"{detector}: {value:.2g}" for value in missing]
        drawn = np.maximum(missing, _NEAREST)
        names, paint = [detector] * len(drawn), colour[detector]
        series.append(Series(detector, "points", drawn, names, colour=paint, where=where, text=text, mark="circle"))
    return Figure(
        "auc",
        "What the curves leave: 1 − area under the ROC curve",
        "1 − area",
        "",
        series,
        _NO_CURVE,
        "The less, the better; half is a coin. Over all false-positive rates, most of which nobody drives with: read it"
        f" beside the curves. What is below {_NEAREST:g} is drawn there.",
        {"xaxis": {"type": "log", "exponentformat": "power"}, "yaxis": {"autorange": "reversed"}},
    )


def cost_of_speed(run: Results) -> Figure:
    """Return false alarms against delay, a point for each detector."""
    colour = colours(detectors_of(run))
    rate = "false_alarms_per_vehicle_hour"
    series = []
    chosen = run.detection[run.detection["detector"].isin(colour) & run.detection["delay_mean_s"].notna()]
    for where, detector, rows in grouped(chosen, "detector"):
        series.append(
            Series(
                detector,
                "points",
                rows["delay_mean_s"],
                rows[rate],
                rows[f"{rate}_lo"],
                rows[f"{rate}_hi"],
                rows["delay_mean_s_lo"],
                rows["delay_mean_s_hi"],
                colour[detector],
                where,
            )
        )
    return Figure(
        "cost",
        "What speed costs: false alarms against delay",
        "mean delay of the attacks that were seen (s)",
        "false alarms per vehicle-hour",
        series,
        "No detector that was compared saw any attack of this kind, so there is no delay to set against false alarms.",
        "A point for each detector and false-alarm rate, with intervals; gpsec run --rates gives further rates.",
        {"xaxis": {"rangemode": "tozero"}, "yaxis": {"rangemode": "tozero"}},
    )


def error_over_time(run: Results, way: str, title: str) -> Figure:
    """Return median and 90 % band of the error `way` (``cross_track``, ``along_track``) of each defence."""
    defences = defences_of(run)
    colour = colours(defences, UNDEFENDED)
    series = []
    for where, defence, rows in grouped(run.error_bands, "defence"):
        time, middle = rows["time_s"], rows[f"{way}_median_m"]
        low, high = rows[f"{way}_p05_m"], rows[f"{way}_p95_m"]
        # Bands of all would hide each other; that of the undefended vehicle is what the others are compared with.
        chosen = {} if defence == UNDEFENDED else {"band": defence}
        name = f"{defence}, 90 %"
        band = Series(name, "band", time, middle, low, high, colour=colour[defence], where=where | chosen, of=defence)
        series += [band, Series(defence, "line", time, middle, colour=colour[defence], where=where)]
    return Figure(
        f"{way}_error",
        title,
        "time since the attack began (s)",
        f"absolute error {title.lower().removeprefix('error ')} (m)",
        series,
        "No vehicle was attacked in this way, so there is no time since an attack began.",
        "Medians of those still under attack then, who are ever fewer towards the right; bands that 90 % of them are"
        " in, of the undefended vehicle and of the defence that is chosen. Click a name to hide it.",
        {"yaxis": {"rangemode": "tozero"}, "xaxis": {"rangemode": "tozero"}},
        labelled=True,
    )


def outcome_shares(run: Results) -> Figure:
    """Return the share of vehicles that would have reached each outcome, with intervals."""
    order = {name: i for i, name in enumerate(defences_of(run))}
    series = []
    keys = ["scenario", "profile", "attack"]
    for names, rows in run.safety.groupby(keys, sort=False, observed=True):
        scenario, profile, attack = map(str, names)
        if not (rows["n_vehicles"] > 0).all() or rows[OUTCOMES[0]].isna().any():
            continue
        ordered = rows.iloc[rows["defence"].astype(str).map(order).argsort()]
        for number, outcome in enumerate(OUTCOMES):
            share, total = f"{outcome}_share", ordered["n_vehicles"]
            series.append(
                Series(
                    outcome.replace("_", " "),
                    "bars",
                    ordered["defence"].tolist(),
                    ordered[share].tolist(),
                    ordered[f"{share}_lo"].tolist(),
                    ordered[f"{share}_hi"].tolist(),
                    colour=_SEVERITY[number],
                    where={"group": group_name(scenario, profile), "attack": attack},
                    text=[f"{count:.0f} of {of}" for count, of in zip(ordered[outcome], total, strict=True)],
                )
            )
    return Figure(
        "outcomes",
        "What it would have meant",
        "",
        "share of the attacked vehicles",
        series,
        "No vehicle was attacked in this way.",
        "Share of the vehicles that would have touched a line, left their lane, got among oncoming traffic or off the"
        " road, had they steered by their estimate; with intervals. Whoever has left the lane has touched a line too.",
        {"yaxis": {"range": [0, 1.02]}},
    )


def all_figures(run: Results, over: Results | None = None) -> dict[str, Figure]:
    """Return the figures of a run by their key; `over` is the run over several seeds, where there are such."""
    outcomes, cost = outcome_shares(run), cost_of_speed(run)
    if over is not None:
        outcomes = replace(outcomes, series=[*outcome_shares(over).series, *outcomes.series])
        cost = replace(cost, series=[*cost_of_speed(over).series, *cost.series])
    figures = [
        outcomes,
        delays(run, over),
        roc(run),
        area_missing(run),
        precision_recall(run),
        cost,
        error_over_time(run, "cross_track", "Error across the lane"),
        error_over_time(run, "along_track", "Error along the lane"),
    ]
    return {figure.key: figure for figure in figures}
