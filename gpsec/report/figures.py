"""The figures of a report, from the tables of a run."""

import numpy as np

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


def delays(run: Results) -> Figure:
    """Return the distribution of detection delays; attacks that were not detected are missing at its right end."""
    colour = colours(detectors_of(run))
    events = run.events.drop_duplicates(["scenario", "vehicle_id", "attack", "detector"])
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
    )


_NO_CURVE = (
    "No sample under this attack could be scored (jamming, for one, takes the fixes away), so the curve is not defined."
)


def roc(run: Results) -> Figure:
    """Return ROC curves, with the detectors as they were run."""
    return _curves(
        run,
        "roc",
        "Receiver operating characteristic",
        ("false_positive_rate", "false-positive rate"),
        ("recall", "true-positive rate"),
        "Shares of the samples that are not attacked, and that are. Lines: the statistic against any threshold."
        " Diamonds: the detector as it was run, with its threshold and its hold of alarms, which is why it may lie off"
        " its line.",
    )


def precision_recall(run: Results) -> Figure:
    """Return precision-recall curves, with the detectors as they were run."""
    return _curves(
        run,
        "pr",
        "Precision and recall",
        ("recall", "recall"),
        ("precision", "precision"),
        "Precision depends on how much of the time is under attack; compare it within a run only."
        " Diamonds: the detector as it was run.",
    )


def _curves(run: Results, key: str, title: str, x: tuple[str, str], y: tuple[str, str], note: str) -> Figure:
    colour = colours(detectors_of(run))
    series = [
        Series(detector, "line", rows[x[0]], rows[y[0]], colour=colour[detector], where=where)
        for where, detector, rows in grouped(run.curves[run.curves["detector"].isin(colour)], "detector")
    ]
    as_run = run.detection[run.detection["detector"].isin(colour) & (run.detection["n_events"] > 0)]
    for where, detector, rows in grouped(as_run, "detector"):
        at = rows[x[0]], rows[y[0]]
        if not np.isnan(at).any():
            series.append(
                Series(f"{detector}, as run", "points", *at, colour=colour[detector], where=where, mark="diamond")
            )
    square = {"range": [-0.02, 1.02]}
    return Figure(key, title, x[1], y[1], series, _NO_CURVE, note, {"xaxis": square, "yaxis": square})


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
        "A point for each detector and false-alarm rate, with intervals; for further rates, run it again with"
        " --set detection.rates=….",
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
        band = Series(f"{defence}, 90 %", "band", time, middle, low, high, colour=colour[defence], where=where | chosen)
        series += [band, Series(defence, "line", time, middle, colour=colour[defence], where=where)]
    return Figure(
        f"{way}_error",
        title,
        "time since the attack began (s)",
        f"absolute error {title.lower().removeprefix('error ')} (m)",
        series,
        "No vehicle was attacked in this way, so there is no time since an attack began.",
        "Medians, and the band that 90 % of the vehicles are in, of those still under attack then; towards the right"
        " they are ever fewer. Click a name to hide it.",
        {"yaxis": {"rangemode": "tozero"}, "xaxis": {"rangemode": "tozero"}},
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


def all_figures(run: Results) -> dict[str, Figure]:
    """Return the figures of a run by their key."""
    figures = [
        outcome_shares(run),
        delays(run),
        roc(run),
        precision_recall(run),
        cost_of_speed(run),
        error_over_time(run, "cross_track", "Error across the lane"),
        error_over_time(run, "along_track", "Error along the lane"),
    ]
    return {figure.key: figure for figure in figures}
