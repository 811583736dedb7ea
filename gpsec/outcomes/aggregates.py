"""The tables with a row for every attack: `detection.csv`, `localization.csv`, `safety.csv`."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats, Longs
from gpsec.outcomes import metrics
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.histograms import areas, matched, negatives
from gpsec.outcomes.metrics import Figures
from gpsec.outcomes.records import cells, error_columns
from gpsec.outcomes.state import ATTACK, AVERAGE_MAX, FALSE, FN, FP, LIFE, LINE_TOUCHED, OUTCOMES, TN, TP
from gpsec.outcomes.study import Study

Columns = dict[str, Any]

# Where more of the honest undefended vehicles than that touch a line, outcomes are those of the receiver.
MEANINGLESS_SHARE = 0.5
MEANINGLESS = "{:.0%} of the honest undefended vehicles touch a line: outcomes would be those of the receiver"
# The outcomes of which is said how many an attack caused: more than the benign twins have.
CAUSED = OUTCOMES[:2]
_NAMED = ("profile", "attack", "defence", "n_vehicles")
# Below this, a bootstrap over vehicles says nothing.
_FEWEST_VEHICLES = 2


class StatisticCounts(NamedTuple):
    """StatisticCounts of statistics.

    Attributes:
        histogram: (P, profiles, K, 2, BINS) of samples not attacked and attacked.
        rises: (profiles, K, BINS) of benign vehicles, see `histograms.count`.
    """

    histogram: Longs
    rises: Longs


def detection_table(
    study: Study, tracks: ClosedTracks, counts: StatisticCounts, scenario: str, bootstrap: Bootstrap
) -> pd.DataFrame:
    """Return one row for every profile, attack and detector."""
    parts = []
    for profile, name in enumerate(study.profiles):
        mine = tracks.take(tracks.profile == profile)
        alarms = _false_alarms(study, mine.of_plan(0), bootstrap, name)
        for plan, attack in enumerate(study.plans):
            chosen = mine.of_plan(plan)
            columns: Columns = {
                "scenario": scenario,
                "profile": name,
                "attack": attack,
                "detector": list(study.detectors),
                "rate": list(study.rates),
                "n_events": len(chosen) if plan > 0 else 0,
            }
            columns |= _detection(study, chosen, bootstrap, f"{name}/{attack}", attacked=plan > 0)
            columns |= _worth(study, chosen, bootstrap, f"{name}/{attack}/worth", attacked=plan > 0)
            columns |= alarms
            columns |= _areas(counts.histogram, profile, plan, chosen)
            columns["threshold"] = study.thresholds[profile]
            columns["threshold_from"] = list(study.origins)
            columns |= matched_columns(study, counts, (profile, plan), chosen.state.peak, alarms["vehicle_hours"])
            parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def localization_table(study: Study, tracks: ClosedTracks, scenario: str, bootstrap: Bootstrap) -> pd.DataFrame:
    """Return one row for every profile, attack and defence: during the attack, "none" over the settled life."""
    parts = []
    for profile, name in enumerate(study.profiles):
        for plan, attack in enumerate(study.plans):
            chosen = tracks.take(tracks.profile == profile).of_plan(plan)
            when = ATTACK if plan > 0 else LIFE
            columns: Columns = {
                "scenario": scenario,
                "profile": name,
                "attack": attack,
                "defence": list(study.defence_names),
                "n_events": len(chosen) if plan > 0 else 0,
                "n_vehicles": len(chosen),
            }
            columns |= _localization(study, chosen, when, bootstrap, f"{name}/{attack}")
            squared = chosen.state.twin_squared_m2.sum(axis=0)
            of_twin = error_columns(squared, np.full(len(squared), chosen.state.steps[:, ATTACK].sum() if plan else 0))
            columns |= {f"twin_{column}": cells(of_twin[column]) for column in ("rmse_xy_m", "rmse_cross_track_m")}
            parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def safety_table(study: Study, tracks: ClosedTracks, scenario: str, bootstrap: Bootstrap) -> pd.DataFrame:
    """Return one row for every profile, attack and defence: how many vehicles would have reached each outcome.

    Where honest undefended vehicles touch a line already, outcomes say nothing of an attack, and are left out.
    """
    parts = []
    for profile, name in enumerate(study.profiles):
        honest = tracks.take(tracks.profile == profile).of_plan(0)
        without = _without_gnss(study, honest, bootstrap, name)
        touched = (honest.state.first_step[:, 0, LINE_TOUCHED] >= 0).mean() if len(honest) else 0.0
        for plan, attack in enumerate(study.plans):
            chosen = tracks.take(tracks.profile == profile).of_plan(plan)
            columns: Columns = {
                "scenario": scenario,
                "profile": name,
                "attack": attack,
                "defence": list(study.defence_names),
                "n_vehicles": len(chosen),
            }
            columns |= _reached(chosen, bootstrap, f"{name}/{attack}/caused", attacked=plan > 0)
            if touched > MEANINGLESS_SHARE:
                columns |= dict.fromkeys(columns.keys() - {"scenario", *_NAMED}, np.nan)
            columns["note"] = MEANINGLESS.format(touched) if touched > MEANINGLESS_SHARE else ""
            columns |= without
            parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def _detection(study: Study, chosen: ClosedTracks, bootstrap: Bootstrap, label: str, *, attacked: bool) -> Columns:
    """Return the columns of K detectors on the attacked tracks; without an attack only the FPR is defined."""
    counts = chosen.state.counts.astype(np.float64)
    detected = chosen.state.detection_step >= 0
    delay = np.where(detected, (chosen.state.detection_step - chosen.start_step[:, None]) * study.step_s, 0.0)
    per_vehicle = np.concatenate([counts, delay[..., None], detected[..., None]], axis=2)
    sums = _resampled(per_vehicle, bootstrap, label)
    columns: Columns = {}
    for name, of in _DETECTION.items():
        columns |= _interval(name, of(sums.each), of(sums.total), of(sums.resampled), bootstrap)
    for name, share in (("delay_median_s", 0.5), ("delay_p95_s", 0.95)):
        columns[name] = cells(metrics.quantiles(delay, detected, share))
    trials = len(chosen) if attacked else 0
    columns |= _share("detected_share", detected.sum(axis=0), trials, bootstrap.confidence)
    columns["false_positive_rate"] = cells(metrics.ratio(sums.total[..., FP], sums.total[..., [FP, TN]].sum(axis=-1)))
    return columns


_DETECTION: dict[str, Callable[[Floats], Figures]] = {
    "precision": lambda sums: metrics.precision(sums[..., TP], sums[..., FP], sums[..., FN]),
    "recall": lambda sums: metrics.recall(sums[..., TP], sums[..., FN]),
    "f1": lambda sums: metrics.f1(sums[..., TP], sums[..., FP], sums[..., FN]),
    "delay_mean_s": lambda sums: metrics.ratio(sums[..., 4], sums[..., 5]),
}


def _false_alarms(study: Study, benign: ClosedTracks, bootstrap: Bootstrap, profile: str) -> Columns:
    """Return the false alarms of K detectors on vehicles without an attack, for each vehicle-hour."""
    onsets = benign.state.onsets[..., FALSE].astype(np.float64)
    hours = np.broadcast_to(benign.state.steps[:, None, LIFE] * (study.step_s / 3600.0), onsets.shape)
    sums = _resampled(np.stack([onsets, hours], axis=2), bootstrap, f"{profile}/false alarms")
    name = "false_alarms_per_vehicle_hour"
    each, rate, resampled = (metrics.ratio(part[..., 0], part[..., 1]) for part in sums)
    columns = _interval(name, each, rate, resampled, bootstrap)
    # Fleets that are drawn from vehicles without a false alarm have none either, however short the time.
    total, total_hours = sums.total[..., 0], sums.total[..., 1]
    bound, none = metrics.poisson_bound_of_none(total_hours, bootstrap.confidence)
    none = none & (total == 0.0)
    columns[f"{name}_lo"] = np.where(none, 0.0, columns[f"{name}_lo"])
    columns[f"{name}_hi"] = np.where(none, bound, columns[f"{name}_hi"])
    return columns | {"vehicle_hours": total_hours}


def _reached(chosen: ClosedTracks, bootstrap: Bootstrap, label: str, *, attacked: bool) -> Columns:
    """Return how many vehicles reached each outcome under D defences, and how many more than their benign twins."""
    reached, of_twin = chosen.state.first_step >= 0, chosen.state.twin_first_step >= 0
    total = reached.sum(axis=0)
    columns: Columns = {outcome: total[:, i] for i, outcome in enumerate(OUTCOMES)}
    for i, outcome in enumerate(OUTCOMES):
        columns |= _share(f"{outcome}_share", total[:, i], len(chosen), bootstrap.confidence)
    caused = reached.astype(np.float64) - of_twin
    trials = np.full((*reached.shape[:2], 1), float(attacked))
    sums = _resampled(np.concatenate([caused, trials], axis=2), bootstrap, label)
    for i, outcome in enumerate(CAUSED):
        each, share, resampled = (metrics.ratio(part[..., i], part[..., -1]) for part in sums)
        columns |= _interval(f"{outcome}_caused_share", each, share, resampled, bootstrap)
    return columns


def _without_gnss(study: Study, honest: ClosedTracks, bootstrap: Bootstrap, profile: str) -> Columns:
    """Return the minutes in an hour in which honest vehicles are without GNSS under D defences."""
    minutes = honest.state.isolated_steps[..., LIFE] * (study.step_s / 60.0)
    hours = np.broadcast_to(honest.state.steps[:, None, LIFE] * (study.step_s / 3600.0), minutes.shape)
    sums = _resampled(np.stack([minutes, hours], axis=2), bootstrap, f"{profile}/without GNSS")
    each, rate, resampled = (metrics.ratio(part[..., 0], part[..., 1]) for part in sums)
    return _interval("isolated_minutes_per_vehicle_hour", each, rate, resampled, bootstrap)


def _worth(study: Study, chosen: ClosedTracks, bootstrap: Bootstrap, label: str, *, attacked: bool) -> Columns:
    """Return what the alarms of K detectors are worth: in time, due to the attack, over when it is over."""
    state, confidence = chosen.state, bootstrap.confidence
    detected = state.detection_step >= 0
    alone = detected & ~state.twin_in_alarm
    columns = _share("detected_not_twin_share", alone.sum(axis=0), len(chosen) if attacked else 0, confidence)
    line = state.first_step[:, 0, LINE_TOUCHED][:, None]
    touched = int((line >= 0).sum()) if attacked else 0
    before = (line >= 0) & detected & (state.detection_step < line)
    columns["n_line_events"] = touched
    columns |= _share("seen_before_line_share", before.sum(axis=0), touched, confidence)
    known = state.tail_end_step >= 0
    late = np.where(known, (state.tail_end_step - chosen.last_step()[:, None]) * study.step_s, 0.0)
    sums = _resampled(np.stack([late, known], axis=2), bootstrap, label)
    each, mean, resampled = (metrics.ratio(part[..., 0], part[..., 1]) for part in sums)
    return columns | _interval("alarm_ends_after_mean_s", each, mean, resampled, bootstrap)


def matched_columns(
    study: Study, counts: StatisticCounts, at: tuple[int, int], peak: Floats, vehicle_hours: Floats
) -> Columns:
    """Return what K detectors do at thresholds that are re-set on the benign vehicles of this run.

    Args:
        study: names.
        counts: of statistics.
        at: index of profile and plan.
        peak: (V, K) largest statistic of each attacked vehicle.
        vehicle_hours: (K,) of benign vehicles.
    """
    profile, plan = at
    columns: Columns = {"matched_threshold": [], "matched_recall": [], "matched_detected_share": []}
    for k, rate in enumerate(study.rates):
        number, _, unit = rate.partition("/")
        benign, attacked = counts.histogram[0, profile, k, 0], counts.histogram[plan, profile, k, 1]
        found = None
        if plan and unit == "h":
            raised = np.cumsum(counts.rises[profile, k, ::-1])[::-1]
            found = matched(benign, attacked, float(number) * float(vehicle_hours[k]), raised)
        elif plan and unit:
            found = matched(benign, attacked, float(number) * float(benign.sum()))
        columns["matched_threshold"].append(found.threshold if found else np.nan)
        columns["matched_recall"].append(found.recall if found else np.nan)
        columns["matched_detected_share"].append((peak[:, k] >= found.threshold).mean() if found else np.nan)
    return columns


def _areas(histogram: Longs, profile: int, plan: int, chosen: ClosedTracks) -> Columns:
    scored = chosen.state.counts[..., [FP, TN]].sum(axis=(0, 2), dtype=np.int64)
    columns: dict[str, list[float]] = {"roc_auc": [], "pr_auc": []}
    for k, attacked in enumerate(histogram[plan, profile, :, 1]):
        both = areas(negatives(histogram[0, profile, k, 0], int(scored[k])), attacked) if plan else None
        columns["roc_auc"].append(both.roc if both else np.nan)
        columns["pr_auc"].append(both.pr if both else np.nan)
    return columns


def _localization(study: Study, chosen: ClosedTracks, when: int, bootstrap: Bootstrap, label: str) -> Columns:
    squared = chosen.state.squared_m2[:, :, when]
    samples = np.broadcast_to(chosen.state.steps[:, when, None, None], (*squared.shape[:2], 1))
    sums = _resampled(np.concatenate([squared, samples], axis=2), bootstrap, label)
    each, total, resampled = (error_columns(part[..., :4], part[..., 4]) for part in sums)
    columns: Columns = {}
    for name in total:
        columns |= _interval(name, each[name], total[name], resampled[name], bootstrap)
    largest = chosen.state.max_cross_m[:, :, when].max(axis=0, initial=0.0)
    columns["max_cross_track_m"] = cells(Figures(largest, sums.total[..., 4] > 0.0))
    return columns | _average_max(chosen, when)


def _average_max(chosen: ClosedTracks, when: int) -> Columns:
    """Return the means over events of the largest errors of each, which only attacks have."""
    events = chosen.state.steps[:, ATTACK] > 0 if when == ATTACK else np.zeros(len(chosen), np.bool_)
    total, count = chosen.state.largest_m[events].sum(axis=0), np.full(chosen.state.largest_m.shape[1], events.sum())
    return {name: cells(metrics.ratio(total[:, part], count)) for part, name in enumerate(AVERAGE_MAX)}


class _Sums(NamedTuple):
    """C sums for K detectors or defences: (V, K, C) of each vehicle, (K, C) of all, (B, K, C) of resampled fleets."""

    each: Floats
    total: Floats
    resampled: Floats


def _resampled(per_vehicle: Floats, bootstrap: Bootstrap, label: str) -> _Sums:
    vehicles, k, c = per_vehicle.shape
    resampled = bootstrap.sums(label, per_vehicle.reshape(vehicles, k * c)).reshape(bootstrap.replicates, k, c)
    return _Sums(per_vehicle, per_vehicle.sum(axis=0), resampled)


def _interval(name: str, each: Figures, total: Figures, resampled: Figures, bootstrap: Bootstrap) -> Columns:
    """Return a figure and its bootstrap interval, which needs two vehicles that the figure is defined for.

    With one there is nothing to resample: every fleet would have its figure, and the interval no width.
    """
    enough = each.known.sum(axis=0) >= _FEWEST_VEHICLES
    low, high = metrics.percentile_interval(resampled, bootstrap.confidence)
    return _with_bounds(name, total, Figures(low.value, low.known & enough), Figures(high.value, high.known & enough))


def _share(name: str, successes: Longs, trials: int, confidence: float) -> Columns:
    every = np.full(len(successes), trials)
    low, high = metrics.wilson_interval(successes, every, confidence)
    return _with_bounds(name, metrics.ratio(successes, every), low, high)


def _with_bounds(name: str, figures: Figures, low: Figures, high: Figures) -> Columns:
    bounds = {
        suffix: cells(Figures(bound.value, bound.known & figures.known))
        for suffix, bound in (("_lo", low), ("_hi", high))
    }
    return {name: cells(figures)} | {name + suffix: values for suffix, values in bounds.items()}
