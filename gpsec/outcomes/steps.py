"""The log of every step (`--log-steps`): a Parquet file with one row for every track and step, written and read."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from gpsec.core.arrays import Flags, Floats
from gpsec.core.errors import GpsecError, shown
from gpsec.core.geo import Projector
from gpsec.outcomes.parquet_log import ParquetLog
from gpsec.outcomes.view import StepView
from gpsec.types.vehicles import Measurements

_TEXTS = ("vehicle_id", "plan", "lane")
_FLAGS = ("settled", "attacked")
_NUMBERS = (
    *("time_s", "x_m", "y_m", "lon_deg", "lat_deg", "yaw_rad", "speed_mps", "fix_x_m", "fix_y_m", "fix_lon_deg"),
    *("fix_lat_deg", "lane_offset_m", "camera_offset_m", "residual_m"),
)


class StepLog(ParquetLog):
    """Writes `steps.parquet` as the run goes on."""

    def __init__(
        self,
        path: Path,
        plan_names: Sequence[str],
        detector_names: Sequence[str],
        defences: Sequence[tuple[str, str]],
        lane_ids: Sequence[str],
        projector: Projector,
    ) -> None:
        self._lane_ids = np.array([*lane_ids, ""], object)
        self._plans = np.array(plan_names, object)
        self._detectors = list(detector_names)
        self._defences = [f"{detector}+{response}" for detector, response in defences]
        self._projector = projector
        super().__init__(path, self._fields())

    def observe(self, view: StepView, vehicle_ids: Sequence[str], seen: Measurements) -> None:
        """Log the tracks `view.rows`; `vehicle_ids` are those of their vehicles, one a track; `seen` has all."""
        rows, tracks, vehicles = view.rows, view.tracks, view.vehicles
        v = tracks.vehicle[rows]
        step = {
            "time_s": np.full(len(rows), view.time_s),
            "vehicle_id": np.array(vehicle_ids, object),
            "plan": self._plans[tracks.plan[rows]],
            "lane": vehicles.lane[v],
            "rear_m": vehicles.rear_m[v],
            "yaw_rad": vehicles.yaw_rad[v],
            "speed_mps": vehicles.speed_mps[v],
            "settled": tracks.settled[rows],
            "attacked": tracks.attacked[rows],
            "fix_m": tracks.fix_m[rows],
            "fix_valid": tracks.fix_valid[rows],
            "lane_offset_m": vehicles.lane_offset_m[v],
            "camera_offset_m": -seen.lane_poly[v, 0],
            "camera_valid": seen.camera_valid[v],
            "residual_m": tracks.residual_m[rows],
            "residual_valid": tracks.residual_valid[rows],
            "statistic": view.answers.statistic[rows],
            "scored": view.answers.scored[rows],
            "alarm": view.answers.alarm[rows],
            "estimate_m": view.answers.estimate_m[rows],
            "isolated": view.answers.isolated[rows],
        }
        self.add(step)

    def add(self, rows: Mapping[str, Any]) -> None:
        """Log rows of a track and step each: names of vehicle and plan, index of the lane, fields of a `StepView`.

        Those that end in `_valid`, and `scored`, say where the others are known.
        """
        self._hold(rows, len(rows["time_s"]))

    def _fields(self) -> Any:
        fields = [("time_s", pa.float64()), ("vehicle_id", pa.string()), ("plan", pa.string())]
        fields += [("lane", pa.string())]
        fields += [(name, pa.float64()) for name in ("x_m", "y_m", "lon_deg", "lat_deg", "yaw_rad", "speed_mps")]
        fields += [("settled", pa.bool_()), ("attacked", pa.bool_())]
        fields += [(f"fix_{name}", pa.float64()) for name in ("x_m", "y_m", "lon_deg", "lat_deg")]
        fields += [(name, pa.float64()) for name in ("lane_offset_m", "camera_offset_m", "residual_m")]
        for name in self._detectors:
            fields += [(f"{name}_statistic", pa.float64()), (f"{name}_alarm", pa.bool_())]
        for name in self._defences:
            fields += [(f"{name}_x_m", pa.float64()), (f"{name}_y_m", pa.float64())]
            fields += [(f"{name}_isolated", pa.bool_())]
        return pa.schema(fields)

    def _columns(self, data: Mapping[str, Any]) -> list[Any]:
        columns: dict[str, Any] = {
            name: data[name] for name in ("time_s", "vehicle_id", "plan", "yaw_rad", "speed_mps", "settled", "attacked")
        }
        columns["lane"] = self._lane_ids[data["lane"]]
        every = np.ones(len(data["rear_m"]), np.bool_)
        columns |= self._positions("", data["rear_m"], every)
        columns |= self._positions("fix_", data["fix_m"], data["fix_valid"])
        columns["lane_offset_m"] = data["lane_offset_m"]
        columns["camera_offset_m"] = pa.array(data["camera_offset_m"], mask=~data["camera_valid"])
        columns["residual_m"] = pa.array(data["residual_m"], mask=~data["residual_valid"])
        for k, name in enumerate(self._detectors):
            columns[f"{name}_statistic"] = pa.array(data["statistic"][:, k], mask=~data["scored"][:, k])
            columns[f"{name}_alarm"] = data["alarm"][:, k]
        for d, name in enumerate(self._defences):
            columns[f"{name}_x_m"] = data["estimate_m"][:, d, 0]
            columns[f"{name}_y_m"] = data["estimate_m"][:, d, 1]
            columns[f"{name}_isolated"] = data["isolated"][:, d]
        for name in ("yaw_rad", "speed_mps", "lane_offset_m"):
            columns[name] = columns[name].astype(np.float64)
        return [pa.array(columns[name]) for name in self._schema.names]

    def _positions(self, prefix: str, position_m: Floats, known: Flags) -> dict[str, Any]:
        lon_lat = np.zeros_like(position_m)
        lon_lat[known] = self._projector.to_lon_lat(position_m[known])
        values = np.concatenate([position_m, lon_lat], axis=1)
        names = ("x_m", "y_m", "lon_deg", "lat_deg")
        return {prefix + name: pa.array(values[:, i], mask=~known) for i, name in enumerate(names)}


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
