"""The error tape of a log's receiver (docs/tapes.md)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError
from gpsec.replay.errors import ErrorSeries
from gpsec.types.tapes import Tape

# Of a Gaussian, σ is so many times the median distance from the median.
_MAD = 1.4826


def receiver_tape(series: ErrorSeries, condition: str, provenance: Mapping[str, Any]) -> Tape:
    """Return the tape of the errors of fixes: each piece less its median, east and north.

    Raises:
        GpsecError: a piece holds too few fixes to say how far they spread.
    """
    there = ~series.missing
    errors = np.where(there[:, None], series.errors, 0.0)
    sigma_m = np.zeros(len(errors))
    medians = []
    ends = [*series.piece[1:].tolist(), len(errors)]
    for begin, end in zip(series.piece.tolist(), ends, strict=True):
        mine = there[begin:end]
        median: Floats = np.median(errors[begin:end][mine], axis=0)
        medians.append(median)
        errors[begin:end][mine] -= median
        spread = _MAD * float(np.median(np.abs(errors[begin:end][mine])))
        sigma_m[begin:end][mine] = spread
    if (sigma_m[there] <= 0.0).any():
        raise GpsecError("fix: expected fixes that differ from the pose by more and less, found all alike")
    return Tape(
        kind="gnss",
        rate_hz=series.rate_hz,
        errors=errors,
        missing=series.missing,
        sigma_m=sigma_m,
        piece=series.piece,
        median=np.array(medians),
        condition=condition,
        provenance=provenance,
    )
