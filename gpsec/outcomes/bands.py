"""The table `error_bands.csv`: errors against the time since the attack began.

Once a second of its attack, the absolute errors of a track go into histograms, one for each of the seconds. Their
memory is that of plans, profiles and defences, whatever the number of vehicles and steps.
"""

from math import cos, frexp, sin

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.outcomes.study import Study
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles

# Attacks that last longer are followed this far.
SECONDS = 120
# Errors of 4 mm to 128 m; a bin is 1/32 to 1/16 of the error wide, and quantiles are interpolated within it.
BANDS_PER_OCTAVE = 16
_LOWEST_OCTAVE, _HIGHEST_OCTAVE = -8, 7
ERROR_BINS = (_HIGHEST_OCTAVE - _LOWEST_OCTAVE) * BANDS_PER_OCTAVE + 2
_ACROSS, _ALONG = 0, 1
SHARES = {"p05": 0.05, "median": 0.5, "p95": 0.95}


def empty_bands(plans: int, profiles: int, defences: int) -> Ints:
    """Return (plans, profiles, D, 2, SECONDS + 1, ERROR_BINS) counts of nothing: across and along the lane."""
    return np.zeros((plans, profiles, defences, 2, SECONDS + 1, ERROR_BINS), np.int32)


@inline
def error_bin(error_m: float) -> int:
    """Return the bin of an absolute error; a larger one never has a lower bin."""
    if not error_m >= 2.0**_LOWEST_OCTAVE:
        return 0
    if error_m >= 2.0**_HIGHEST_OCTAVE:
        return ERROR_BINS - 1
    mantissa, exponent = frexp(error_m)
    return 1 + (exponent - 1 - _LOWEST_OCTAVE) * BANDS_PER_OCTAVE + int((mantissa - 0.5) * (2.0 * BANDS_PER_OCTAVE))


@kernel
def add_bands(
    rows: Ints, step: int, stride: int, tracks: Tracks, vehicles: Vehicles, estimate_m: Floats, bands: Ints
) -> None:
    """Add the errors of (M, D, 2) estimates of those `rows` whose attack is a multiple of `stride` steps old.

    Those on a lane that leads the other way are left out. Several rows share a cell, so this is not for more than one
    thread; the sums do not depend on the order.
    """
    for row in rows:
        v = tracks.vehicle[row]
        if not tracks.attacked[row] or vehicles.against[v]:
            continue
        age = step - tracks.start_step[row]
        second = age // stride
        if age % stride != 0 or second > SECONDS:
            continue
        c, s = cos(vehicles.lane_yaw_rad[v]), sin(vehicles.lane_yaw_rad[v])
        cells = bands[tracks.plan[row], vehicles.profile[v]]
        for d in range(estimate_m.shape[1]):
            x = estimate_m[row, d, 0] - vehicles.rear_m[v, 0]
            y = estimate_m[row, d, 1] - vehicles.rear_m[v, 1]
            cells[d, _ACROSS, second, error_bin(abs(c * y - s * x))] += 1
            cells[d, _ALONG, second, error_bin(abs(c * x + s * y))] += 1


def stride(step_s: float) -> int:
    """Return the number of steps that are closest to a second."""
    return max(1, round(1.0 / step_s))


def error_edges() -> Floats:
    """Return the (ERROR_BINS + 1,) bounds of the bins; the last bin ends where it begins."""
    octave, part = np.divmod(np.arange(ERROR_BINS - 1), BANDS_PER_OCTAVE)
    inner = np.ldexp(1.0 + part / BANDS_PER_OCTAVE, octave + _LOWEST_OCTAVE)
    return np.concatenate([[0.0], inner, inner[-1:]])


def quantile(counts: Ints, share: float) -> Floats:
    """Return the (T,) errors below which `share` of (T, ERROR_BINS) counts lie, interpolated within the bin."""
    edges = error_edges()
    below = np.cumsum(counts, axis=1)
    wanted = share * below[:, -1:]
    place = np.minimum((below < wanted).sum(axis=1), ERROR_BINS - 1)
    every = np.arange(len(counts))
    inside = counts[every, place]
    missing = wanted[:, 0] - (below[every, place] - inside)
    part = np.divide(missing, inside, out=np.zeros(len(counts)), where=inside > 0)
    found: Floats = edges[place] + part * (edges[place + 1] - edges[place])
    return found


def bands_table(study: Study, bands: Ints, scenario: str) -> pd.DataFrame:
    """Return a row for every profile, attack, defence and second of the attack that a vehicle was under."""
    names = ["scenario", "profile", "attack", "defence"]
    numbers = [f"{way}_{share}_m" for way in ("cross_track", "along_track") for share in SHARES]
    parts = [pd.DataFrame({name: np.zeros(0, object if name in names else float) for name in [*names, "time_s"]})]
    parts[0] = parts[0].assign(n_vehicles=np.zeros(0, np.int64), **dict.fromkeys(numbers, 0.0))
    between_s = stride(study.step_s) * study.step_s
    for profile, name in enumerate(study.profiles):
        for plan, attack in enumerate(study.plans[1:], start=1):
            for d, defence in enumerate(study.defence_names):
                cell = bands[plan, profile, d]
                vehicles = cell[_ACROSS].sum(axis=1)
                seen = np.flatnonzero(vehicles)
                if not len(seen):
                    continue
                columns = {"scenario": scenario, "profile": name, "attack": attack, "defence": defence}
                errors = {
                    f"{way}_{share}_m": quantile(cell[axis, seen], part)
                    for axis, way in ((_ACROSS, "cross_track"), (_ALONG, "along_track"))
                    for share, part in SHARES.items()
                }
                parts.append(
                    pd.DataFrame({**columns, "time_s": seen * between_s, "n_vehicles": vehicles[seen], **errors})
                )
    return pd.concat([part for part in parts if len(part)] or parts, ignore_index=True)
