"""The tables with a row for every attack: `detection.csv`, `localization.csv`, `safety.csv`."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pandas as pd

from gpsec.arrays import Floats, Longs
from gpsec.outcomes import metrics
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.histograms import areas, negatives
from gpsec.outcomes.metrics import Figures
from gpsec.outcomes.records import cells, error_columns
from gpsec.outcomes.state import ATTACK, FALSE, FN, FP, LIFE, OUTCOMES, TN, TP
from gpsec.outcomes.study import Study

Columns = dict[str, Any]


def detection_table(
    study: Study, tracks: ClosedTracks, histogram: Longs, scenario: str, bootstrap: Bootstrap
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
                "n_events": len(chosen) if plan > 0 else 0,
            }
            columns |= _detection(study, chosen, bootstrap, f"{name}/{attack}", attacked=plan > 0)
            columns |= alarms
            columns |= _areas(histogram, profile, plan, chosen)
            columns["threshold"] = study.thresholds[profile]
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
            parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def safety_table(study: Study, tracks: ClosedTracks, scenario: str, confidence: float) -> pd.DataFrame:
    """Return one row for every attack and defence: how many vehicles would have reached each outcome."""
    parts = []
    for plan, attack in enumerate(study.plans):
        chosen = tracks.of_plan(plan)
        columns: Columns = {
            "scenario": scenario,
            "attack": attack,
            "defence": list(study.defence_names),
            "n_vehicles": len(chosen),
        }
        reached = (chosen.state.first_step >= 0).sum(axis=0)
        for outcome, name in enumerate(OUTCOMES):
            columns[name] = reached[:, outcome]
        for outcome, name in enumerate(OUTCOMES):
            columns |= _share(f"{name}_share", reached[:, outcome], len(chosen), confidence)
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def _detection(study: Study, chosen: ClosedTracks, bootstrap: Bootstrap, label: str, *, attacked: bool) -> Columns:
    """Return the columns of K detectors on the attacked tracks; without an attack only the FPR is defined."""
    counts = chosen.state.counts.astype(np.float64)
    detected = chosen.state.detection_step >= 0
    delay = np.where(detected, (chosen.state.detection_step - chosen.start_step[:, None]) * study.step_s, 0.0)
    per_vehicle = np.concatenate([counts, delay[..., None], detected[..., None]], axis=2)
    total, replicates = _resampled(per_vehicle, bootstrap, label)
    columns: Columns = {}
    for name, of in _DETECTION.items():
        columns |= _interval(name, of(total), of(replicates), bootstrap, known=attacked)
    columns |= _interval("delay_mean_s", _mean_delay(total), _mean_delay(replicates), bootstrap)
    for name, share in (("delay_median_s", 0.5), ("delay_p95_s", 0.95)):
        columns[name] = cells(metrics.quantiles(delay, detected, share))
    trials = len(chosen) if attacked else 0
    columns |= _share("detected_share", detected.sum(axis=0), trials, bootstrap.confidence)
    columns["false_positive_rate"] = cells(metrics.ratio(total[..., FP], total[..., FP] + total[..., TN]))
    return columns


_DETECTION: dict[str, Callable[[Floats], Figures]] = {
    "precision": lambda sums: metrics.precision(sums[..., TP], sums[..., FP]),
    "recall": lambda sums: metrics.recall(sums[..., TP], sums[..., FN]),
    "f1": lambda sums: metrics.f1(sums[..., TP], sums[..., FP], sums[..., FN]),
}


def _mean_delay(sums: Floats) -> Figures:
    return metrics.ratio(sums[..., 4], sums[..., 5])


def _false_alarms(study: Study, benign: ClosedTracks, bootstrap: Bootstrap, profile: str) -> Columns:
    """Return the false alarms of K detectors on vehicles without an attack, for each vehicle-hour."""
    onsets = benign.state.onsets[..., FALSE].astype(np.float64)
    hours = np.broadcast_to(benign.state.steps[:, None, LIFE] * (study.step_s / 3600.0), onsets.shape)
    total, replicates = _resampled(np.stack([onsets, hours], axis=2), bootstrap, f"{profile}/false alarms")
    name = "false_alarms_per_vehicle_hour"
    rate, rates = (metrics.ratio(sums[..., 0], sums[..., 1]) for sums in (total, replicates))
    return _interval(name, rate, rates, bootstrap) | {"vehicle_hours": total[..., 1]}


def _areas(histogram: Longs, profile: int, plan: int, chosen: ClosedTracks) -> Columns:
    scored = chosen.state.counts[..., [FP, TN]].sum(axis=(0, 2), dtype=np.int64)
    columns: dict[str, list[float]] = {"roc_auc": [], "pr_auc": []}
    for k, (clear, attacked) in enumerate(histogram[plan, profile]):
        both = areas(negatives(histogram[0, profile, k, 0], clear, int(scored[k])), attacked) if plan else None
        columns["roc_auc"].append(both.roc if both else np.nan)
        columns["pr_auc"].append(both.pr if both else np.nan)
    return columns


def _localization(study: Study, chosen: ClosedTracks, when: int, bootstrap: Bootstrap, label: str) -> Columns:
    squared = chosen.state.squared_m2[:, :, when]
    samples = np.broadcast_to(chosen.state.steps[:, when, None, None], (*squared.shape[:2], 1))
    total, replicates = _resampled(np.concatenate([squared, samples], axis=2), bootstrap, label)
    estimate, resampled = (error_columns(sums[..., :4], sums[..., 4]) for sums in (total, replicates))
    columns: Columns = {}
    for name, figures in estimate.items():
        columns |= _interval(name, figures, resampled[name], bootstrap)
    largest = chosen.state.max_cross_m[:, :, when].max(axis=0, initial=0.0)
    columns["max_cross_track_m"] = cells(Figures(largest, total[..., 4] > 0.0))
    return columns


def _resampled(per_vehicle: Floats, bootstrap: Bootstrap, label: str) -> tuple[Floats, Floats]:
    """Return (K, C) sums over all vehicles and (B, K, C) over resampled ones, of (V, K, C)."""
    vehicles, k, c = per_vehicle.shape
    sums = bootstrap.sums(label, per_vehicle.reshape(vehicles, k * c))
    return per_vehicle.sum(axis=0), sums.reshape(bootstrap.replicates, k, c)


def _interval(name: str, figures: Figures, replicates: Figures, bootstrap: Bootstrap, *, known: bool = True) -> Columns:
    low, high = metrics.percentile_interval(replicates, bootstrap.confidence)
    return dict(_with_bounds(name, figures, low, high, known=known))


def _share(name: str, successes: Longs, trials: int, confidence: float) -> Columns:
    every = np.full(len(successes), trials)
    low, high = metrics.wilson_interval(successes, every, confidence)
    return dict(_with_bounds(name, metrics.ratio(successes, every), low, high))


def _with_bounds(
    name: str, figures: Figures, low: Figures, high: Figures, *, known: bool = True
) -> Iterator[tuple[str, Floats]]:
    for suffix, part in (("", figures), ("_lo", low), ("_hi", high)):
        yield name + suffix, cells(Figures(part.value, part.known & figures.known & known))
