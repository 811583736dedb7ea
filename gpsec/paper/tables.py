"""Tables I to IV: the paper's figure, ours and its interval side by side."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, fields
from pathlib import Path

import pandas as pd

from gpsec.detection.calibration import RATES
from gpsec.outcomes.paper import PublishedRmse, detection_like
from gpsec.outcomes.tables import FLOAT_FORMAT, whole
from gpsec.paper import pool
from gpsec.paper.design import (
    AS_WRITTEN,
    CONSTANT_BIAS,
    LANE_ALIAS,
    NONE,
    PAPER,
    SET_UPS,
    SLOW_STEALTH,
    STEALTH,
    Pinned,
)
from gpsec.paper.pool import Estimate
from gpsec.types.constants import ASSOCIATIONS
from gpsec.types.points import PER_SAMPLE

LEARNED, JOINT = "lstm_glr", "joint"
# What the paper compares its detector with, and the test that needs no learning; all see the residual alone.
BASELINES = ("chi_square", "cusum", "isolation_forest")
METRICS = ("precision", "recall", "f1", "delay_mean_s")
# How rows begin of the paper as written, and of what a set-up's simulator gives.
WRITTEN, SIMULATOR = "as written", "simulator"


@dataclass(frozen=True)
class PaperRow:
    """A line of a table: `paper` is None where the paper says nothing of it."""

    row: str
    metric: str
    paper: float | None
    gpsec: float | None
    lo: float | None
    hi: float | None
    n: int


def write_table(rows: Iterable[PaperRow], path: Path) -> None:
    """Write rows as CSV."""
    columns = [field.name for field in fields(PaperRow)]
    table = pd.DataFrame([astuple(row) for row in rows], columns=columns)
    with whole(path) as partial:
        table.to_csv(partial, index=False, float_format=FLOAT_FORMAT, lineterminator="\n", encoding="utf-8")


def write_tidy(rows: Sequence[PaperRow], path: Path) -> None:
    """Write the rows of Table I as CSV, their keys in columns of their own: see `keys_of`."""
    table = pd.DataFrame([{**keys_of(row.row), **asdict(row)} for row in rows]).drop(columns="row")
    with whole(path) as partial:
        table.to_csv(partial, index=False, float_format=FLOAT_FORMAT, lineterminator="\n", encoding="utf-8")


def keys_of(row: str) -> dict[str, str]:
    """Return set-up, association, rate, attack and detector of a row of Table I by its label; empty what it lacks."""
    *others, attack, detector = row.split(" / ")
    association = next((part for part in others if part in ASSOCIATIONS), "")
    rate = next((part for part in others if part in RATES), "")
    set_up = ", ".join(part for part in others if part not in (association, rate))
    return {"set_up": set_up, "association": association, "rate": rate, "attack": attack, "detector": detector}


def write_pinned(pinned: Pinned, path: Path) -> None:
    """Write what was pinned as CSV."""
    table = pd.DataFrame({"profile": list(SET_UPS), "network": list(SET_UPS.values())})
    table["delta"] = table["profile"].map(pinned.delta)
    table["bias_m"] = table["profile"].map(pinned.bias_m)
    with whole(path) as partial:
        table.to_csv(partial, index=False, lineterminator="\n", encoding="utf-8")


def detection_rows(
    label: str, events: pd.DataFrame, vehicles: pd.DataFrame, attacks: Mapping[str, str]
) -> list[PaperRow]:
    """Return the rows of Table I's form from tables of runs; `attacks` is attack of the paper -> plan of the runs."""
    detectors = scored(events)
    rows = []
    for attack, plan in attacks.items():
        of = {name: pool.of_detector(events, name, plan) for name in detectors}
        for name, mine in of.items():
            published = detection_like(attack, name)
            rows += _rows(
                f"{label} / {attack} / {name}",
                pool.detection(mine),
                dict(zip(METRICS, astuple(published), strict=True)) if published else {},
            )
        if LEARNED in of:
            if others := [of[name] for name in BASELINES if name in of]:
                lead = pool.f1_lead(of[LEARNED], others)
                rows += _rows(f"{label} / {attack} / {LEARNED} − best baseline", {"f1": lead})
            if JOINT in of:
                lead = pool.f1_lead(of[JOINT], [of[LEARNED]])
                rows += _rows(f"{label} / {attack} / {JOINT} − {LEARNED}", {"f1": lead})
    for name in detectors:
        rows += _rows(f"{label} / none / {name}", {"false_alarms_per_vehicle_hour": pool.false_alarms(vehicles, name)})
    return rows


def localization_rows(table: PublishedRmse, events: pd.DataFrame, label: str = "") -> list[PaperRow]:
    """Return the rows of Tables II to IV's form: every attack under every defence, beginning with `label`.

    The paper has one response; its figures stand beside that, behind its detector and behind the truth, and beside
    the undefended vehicle, under the constant bias that is scaled to the latter.
    """
    mitigated = {"+".join(defence): table.mitigated_m for defence in (PAPER, AS_WRITTEN, ("told", PAPER[1]))}
    published = {"+".join(NONE): table.undefended_m} | mitigated
    rows = []
    for attack in (name for name in (CONSTANT_BIAS, STEALTH, SLOW_STEALTH) if name in set(events["attack"])):
        for defence in events["defence"].unique():
            mine = pool.of_defence(events, defence, attack)
            theirs = published.get(defence) if attack == CONSTANT_BIAS else None
            names = dict(zip(pool.ERRORS, theirs, strict=False)) if theirs else {}
            rows += _rows(" / ".join(filter(None, (label, attack, defence))), pool.localization(mine), names)
    return rows


def odometer_rows(events_at: Mapping[float, pd.DataFrame]) -> Iterator[PaperRow]:
    """Yield the errors of the paper's UKF that is told at once, by the scale error of the odometer."""
    for scale, events in events_at.items():
        mine = pool.of_defence(events, f"told+{AS_WRITTEN[1]}", CONSTANT_BIAS)
        yield from _rows(f"odometer scale {scale:.3%}", pool.localization(mine))


def generalisation_rows(training: pd.DataFrame, evaluation: pd.DataFrame) -> Iterator[PaperRow]:
    """Yield the F1 on the networks that detectors were trained on (other seeds), on others, and the drop."""
    for profile in SET_UPS:
        for attack in (CONSTANT_BIAS, STEALTH):
            for name in scored(training):
                scores = {}
                for where, events in (("training", training), ("evaluation", evaluation)):
                    mine = pool.of_detector(events[events["profile"] == profile], name, f"{attack}_{profile}")
                    scores[where] = pool.detection(mine)["f1"]
                label = f"generalisation / {profile} / {attack} / {name}"
                yield from _rows(label, {f"f1_{where}_networks": score for where, score in scores.items()})
                here, there = scores["training"].value, scores["evaluation"].value
                drop = here - there if here is not None and there is not None else None
                yield PaperRow(label, "f1_drop", None, drop, None, None, scores["evaluation"].n)


def alias_rows(label: str, events: pd.DataFrame) -> Iterator[PaperRow]:
    """Yield what is seen of a bias of one lane width."""
    for profile in SET_UPS:
        for name in scored(events):
            mine = pool.of_detector(events[events["profile"] == profile], name, LANE_ALIAS)
            yield from _rows(f"{label} / {profile} / {LANE_ALIAS} / {name}", pool.detection(mine))


def _rows(label: str, figures: Mapping[str, Estimate], published: Mapping[str, float] | None = None) -> list[PaperRow]:
    return [
        PaperRow(label, metric, (published or {}).get(metric), found.value, found.low, found.high, found.n)
        for metric, found in figures.items()
    ]


def scored(events: pd.DataFrame) -> Sequence[str]:
    """Return the detectors of the runs, without the bounds."""
    return [name for name in events["detector"].unique() if name not in ("never", "told")]


def at(label: str, rate: str = PER_SAMPLE, association: str = "tracked") -> str:
    """Return the label of rows of one operating point."""
    return f"{label} / {association} / {rate}"
