"""Reads the step log of a run, which anybody may have edited."""

from pathlib import Path

import pandas as pd
import pyarrow as pa

from gpsec.core.errors import GpsecError, shown

_TEXTS = ("vehicle_id", "plan", "lane")
_FLAGS = ("settled", "attacked")
_NUMBERS = (
    *("time_s", "x_m", "y_m", "lon_deg", "lat_deg", "yaw_rad", "speed_mps", "fix_x_m", "fix_y_m", "fix_lon_deg"),
    *("fix_lat_deg", "lane_offset_m", "camera_offset_m", "residual_m"),
)


def read_steps(path: Path, vehicles: list[str] | None) -> pd.DataFrame:
    """Return the steps in a log, of all or some of the vehicles.

    Raises:
        GpsecError: it is no such log.
    """
    filters = None if vehicles is None else [("vehicle_id", "in", vehicles)]
    try:
        steps = pd.read_parquet(path, filters=filters)
    except (OSError, ValueError, LookupError, TypeError, MemoryError, pa.ArrowException) as error:
        raise GpsecError(f"{path}: expected the steps of a run, found another file ({shown(error)})") from None
    names = [str(column) for column in steps]
    flags = [*_FLAGS, *(name for name in names if name.endswith(("_alarm", "_isolated")))]
    defences = [name.removesuffix("_isolated") for name in names if name.endswith("_isolated")]
    estimates = [f"{name}_{axis}_m" for name in defences for axis in "xy"]
    statistics = [name for name in names if name.endswith("_statistic")]
    for wanted, kinds in ((_TEXTS, "OU"), (flags, "b"), ((*_NUMBERS, *estimates, *statistics), "f")):
        for name in wanted:
            if name not in names:
                raise GpsecError(f"{path}: expected the steps of a run, found no column '{shown(name)}'")
            if len(steps) and steps[name].dtype.kind not in kinds:
                raise GpsecError(f"{path}: column '{shown(name)}': expected another type, found {steps[name].dtype}")
    return steps
