"""The error table and the tapes of what was measured."""

import csv
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence
from gpsec.imaging.filming.measure import Errors
from gpsec.types.tapes import Tape

CLEAR_M = 45.0
"""From here on junctions do not hide the lane ahead."""
SEEN_BY = ("single", "memory")
ERROR_PLACES = ("all", "clear")
_DRAWS, _CONFIDENCE = 400, 0.95
# What a tape keeps of C0 … C3: far below their errors, and packed it takes a third of the room.
_GRAIN = np.array([1e-4, 1e-6, 1e-8, 1e-10])
# What is further off is another lane: while a line is crossed, picture and truth may name different ones. A tape has it
# as missing, since it would be played where nobody changes lanes.
_NEXT_LANE_M = 1.4
# A piece of a tape is at least so long.
_LEAST_S = 2.0
_MAD = 1.4826


class ErrorRow(NamedTuple):
    """A row of the table; ranges are of a bootstrap over vehicles, at 95 %.

    Attributes:
        scenario, weather, mode, place: what it is of; ``clear`` is beyond 45 m from junctions.
        vehicles, pictures: how many.
        lost_share: pictures without a lane, of those in which the lane is marked; with its range.
        c0_mean_m, c0_mad_m: mean, and 1.4826 MAD about the median, of the error of C0; with its range.
        c0_p99_m: of its size.
        c1_mad_deg: the same of C1 as an angle.
        tau_s: when the autocorrelation of C0, less each vehicle's median, falls to 1/e.
        sigma_ratio: 1.4826 MAD of the error over the stated σ; 1 where what is stated is right.
    """

    scenario: str
    weather: str
    mode: str
    place: str
    vehicles: int
    pictures: int
    lost_share: float
    lost_low: float
    lost_high: float
    c0_mean_m: float
    c0_mad_m: float
    c0_mad_low_m: float
    c0_mad_high_m: float
    c0_p99_m: float
    c1_mad_deg: float
    tau_s: float
    sigma_ratio: float


def figures_of(scenario: str, weather: str, measured: Sequence[Errors], step_s: float) -> list[ErrorRow]:
    """Return the rows of a weather: both modes, at all places and clear of junctions."""
    return [
        figure
        for mode in SEEN_BY
        for place in ERROR_PLACES
        if (figure := _figure((scenario, weather, mode, place), measured, step_s)) is not None
    ]


def _figure(what: tuple[str, str, str, str], measured: Sequence[Errors], step_s: float) -> ErrorRow | None:
    _, _, mode, place = what
    parts = []
    for errors in measured:
        there = errors.clear_m > CLEAR_M if place == "clear" else np.ones(len(errors.found), np.bool_)
        if there.any():
            parts.append((errors, there))
    if not parts or not any((errors.found & there).any() for errors, there in parts):
        return None
    lost = np.array([[int((~errors.found & there).sum()), int(there.sum())] for errors, there in parts])
    values = [_of(errors, mode)[0][errors.found & there] for errors, there in parts]
    sigmas = np.concatenate([_of(errors, mode)[1][errors.found & there] for errors, there in parts])
    draws = np.random.default_rng(0).integers(0, len(parts), (_DRAWS, len(parts)))
    shares = [lost[draw, 0].sum() / lost[draw, 1].sum() for draw in draws]
    spreads = [robust_spread(np.concatenate([values[at][:, 0] for at in draw])) for draw in draws]
    tail = 0.5 * (1.0 - _CONFIDENCE)
    together = np.concatenate(values)
    c0 = together[:, 0]
    mad_low, mad_high = np.nanquantile(spreads, (tail, 1.0 - tail))
    lost_low, lost_high = np.quantile(shares, (tail, 1.0 - tail))
    return ErrorRow(
        *what,
        len(parts),
        int(lost[:, 1].sum()),
        float(lost[:, 0].sum() / lost[:, 1].sum()),
        float(lost_low),
        float(lost_high),
        float(c0.mean()),
        robust_spread(c0),
        float(mad_low),
        float(mad_high),
        float(np.quantile(np.abs(c0), 0.99)),
        float(np.degrees(robust_spread(np.arctan(together[:, 1])))),
        decay_s(
            [(_of(errors, mode)[0][:, 0], errors._replace(found=errors.found & there)) for errors, there in parts],
            step_s,
        ),
        robust_spread(c0 / sigmas),
    )


def _of(errors: Errors, mode: str) -> tuple[Floats, Floats]:
    return (errors.single, errors.single_sigma_m) if mode == "single" else (errors.kept, errors.kept_sigma_m)


def robust_spread(values: Floats) -> float:
    """Return 1.4826 MAD about the median, which is σ of a normal distribution; 0 for no values."""
    return _MAD * float(np.median(np.abs(values - np.median(values)))) if len(values) else 0.0


def correlations(series: Sequence[tuple[Floats, Errors]], lags: int) -> Floats:
    """Return the autocorrelation of (n,) errors of each vehicle, less their median, at 0 … `lags` - 1 steps.

    Errors of pictures that show the next lane are left out: one of them outweighs a thousand others.
    """
    sums, counts = np.zeros(lags), np.zeros(lags)
    for values, errors in series:
        if not errors.found.any():
            continue
        first, last = int(errors.moment[0]), int(errors.moment[-1])
        line, there = np.zeros(last - first + 1), np.zeros(last - first + 1, np.bool_)
        at = errors.moment[errors.found] - first
        away = values[errors.found] - np.median(values[errors.found])
        line[at], there[at] = away, np.abs(away) <= _NEXT_LANE_M
        for lag in range(min(lags, len(line))):
            both = there[: len(line) - lag] & there[lag:]
            sums[lag] += float((line[: len(line) - lag] * line[lag:])[both].sum())
            counts[lag] += int(both.sum())
    mean: Floats = sums / np.maximum(counts, 1.0)
    return mean / mean[0] if mean[0] > 0.0 else mean


def decay_s(series: Sequence[tuple[Floats, Errors]], step_s: float) -> float:
    """Return when the autocorrelation falls to 1/e, between samples by a straight line."""
    curve = correlations(series, 200)
    below = np.flatnonzero(curve < np.exp(-1.0))
    if not len(below) or below[0] == 0:
        return 0.0
    k = int(below[0])
    return step_s * (k - 1 + float((curve[k - 1] - np.exp(-1.0)) / (curve[k - 1] - curve[k])))


def write_errors(figures: Sequence[ErrorRow], path: Path) -> None:
    """Write the error table.

    Raises:
        GpsecError: it cannot be written.
    """
    with in_a_sentence(f"{path}: no table can be written there"):
        part = path.with_name(f".{path.name}.part")
        with part.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(ErrorRow._fields)
            table.writerows([f"{value:.4g}" if isinstance(value, float) else value for value in row] for row in figures)
        part.replace(path)


def tape_of(
    measured: Sequence[Errors], mode: str, condition: str, step_s: float, provenance: Mapping[str, Any]
) -> Tape:
    """Return the tape of what was measured: a piece for each stretch on which a vehicle could see its lane.

    Raises:
        GpsecError: no stretch is long enough, or nothing was found on any.
    """
    least = round(_LEAST_S / step_s)
    errors_of, missing, sigmas, pieces, medians, length = [], [], [], [], [], 0
    for errors in measured:
        values, sigma = _of(errors, mode)
        for part in _stretches(errors.moment):
            found = errors.found[part]
            if part.stop - part.start < least or not found.any():
                continue
            middle = np.median(values[part][found], axis=0)
            off = values[part] - middle
            found = found & (np.abs(off[:, 0]) < _NEXT_LANE_M)
            errors_of.append(np.round(off / _GRAIN) * _GRAIN * found[:, None])
            missing.append(~found)
            sigmas.append(np.round(sigma[part], 4) * found)
            pieces.append(length)
            medians.append(middle)
            length += part.stop - part.start
    if not pieces:
        raise GpsecError(f"{condition}: expected {_LEAST_S:g} s of a lane that is seen, found no such stretch")
    return Tape(
        "camera",
        1.0 / step_s,
        np.concatenate(errors_of),
        np.concatenate(missing),
        np.concatenate(sigmas),
        np.array(pieces),
        np.array(medians),
        condition,
        provenance,
    )


def _stretches(moment: np.ndarray) -> list[slice]:
    """Return the runs of moments that follow each other."""
    cuts = [0, *(np.flatnonzero(np.diff(moment) != 1) + 1).tolist(), len(moment)]
    return [slice(a, b) for a, b in pairwise(cuts) if b > a]
