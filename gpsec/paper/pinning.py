"""Chooses δ and the bias, which the paper leaves open, so that training runs match figures that it gives."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gpsec.core.errors import GpsecError
from gpsec.outcomes.paper import TABLE_I
from gpsec.paper import pool
from gpsec.paper.design import (
    NONE,
    PIN_DELTAS,
    SET_UPS,
    Pinned,
    target_m,
)

# Whose delay is made the paper's: a baseline's, so that the LSTM's own is a result.
ANCHOR = "isolation_forest"


def pin(runs: Sequence[Path]) -> Pinned:
    """Return δ and the bias for each profile, from the runs of `Studies.pin`.

    δ: the isolation forest's mean delay falls as δ grows; between the two values that enclose the paper's delay it is
    interpolated, and rounded to 0.01. Bias: the undefended RMSE is proportional to it, so it is scaled to the paper's.

    Raises:
        GpsecError: no δ gives the paper's delay.
    """
    events = pool.read_runs(runs, "events")
    delta, bias_m = {}, {}
    for profile in SET_UPS:
        mine = events[events["profile"] == profile]
        delays = [
            pool.of_detector(mine, ANCHOR, f"stealth_{each:g}")["detection_delay_s"].mean() for each in PIN_DELTAS
        ]
        delta[profile] = _crossing(profile, delays, TABLE_I["stealth", ANCHOR].delay_s)
        undefended = pool.of_defence(mine, "+".join(NONE), f"constant_{profile}")
        measured_m = pool.localization(undefended)["rmse_xy_m"].value
        if not measured_m:
            raise GpsecError(f"no vehicle with the profile '{profile}' was attacked on the training networks")
        bias_m[profile] = round(target_m(profile) ** 2 / measured_m, 2)
    return Pinned(delta, bias_m)


def _crossing(profile: str, delays_s: Sequence[float], wanted_s: float) -> float:
    if not delays_s[-1] <= wanted_s <= delays_s[0]:
        raise GpsecError(
            f"the {ANCHOR} takes {delays_s[0]:.2f} s at δ = {PIN_DELTAS[0]:g} and {delays_s[-1]:.2f} s at"
            f" {PIN_DELTAS[-1]:g} with the profile '{profile}': expected {wanted_s:g} s between them"
        )
    return round(float(np.interp(-wanted_s, -np.asarray(delays_s), PIN_DELTAS)), 2)
