"""One file of a dataset: a row for every track and step, in Parquet."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from gpsec.outcomes.parquet_log import ParquetLog
from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.study import Study
from gpsec.outcomes.view import StepView
from gpsec.types.vehicles import Identity

_NAME = pa.dictionary(pa.int32(), pa.string())


class Column(NamedTuple):
    """A column of the dataset.

    Attributes:
        kind: Arrow's type.
        meaning: for the data card, with the unit.
        values: of the tracks `view.rows`, whose vehicle rows are the second argument.
        known: likewise, where there is a value; None where there always is one.
    """

    kind: Any
    meaning: str
    values: Callable[[StepView, Any], Any]
    known: Callable[[StepView, Any], Any] | None = None


def _seen_fix(view: StepView, v: Any) -> Any:
    return view.tracks.fix_valid[view.rows]


def _seen_lane(view: StepView, v: Any) -> Any:
    return view.seen.camera_valid[v]


def _settled(view: StepView, v: Any) -> Any:
    return view.tracks.settled[view.rows]


def _has_residual(view: StepView, v: Any) -> Any:
    return view.tracks.residual_valid[view.rows]


MEASURED: Mapping[str, Column] = {
    "step": Column(pa.int32(), "number of the step of the run", lambda view, v: np.full(len(v), view.step)),
    "time_s": Column(pa.float64(), "simulated time after the step, s", lambda view, v: np.full(len(v), view.time_s)),
    "settled": Column(
        pa.bool_(),
        "the vehicle has been on the road for 10 s; others are not scored",
        _settled,
    ),
    "attacked": Column(
        pa.bool_(), "**label**: the fix of this step is under attack", lambda view, v: view.tracks.attacked[view.rows]
    ),
    "residual_m": Column(
        pa.float32(),
        "camera lane offset less map-matched lane offset of the fix, m; null where none was formed",
        lambda view, v: view.tracks.residual_m[view.rows],
        _has_residual,
    ),
    "fix_east_m": Column(
        pa.float64(),
        "GNSS after the attack, m east in the frame of the net; null without a fix",
        lambda view, v: view.tracks.fix_m[view.rows, 0],
        _seen_fix,
    ),
    "fix_north_m": Column(
        pa.float64(), "the same, m north", lambda view, v: view.tracks.fix_m[view.rows, 1], _seen_fix
    ),
    "camera_offset_m": Column(
        pa.float32(),
        "offset from the lane's centre that the camera sees, m, left positive; null where it sees none",
        lambda view, v: -view.seen.lane_poly[v, 0],
        _seen_lane,
    ),
    "camera_angle": Column(
        pa.float32(),
        "C1 of the camera's lane (Eq 1): tangent of its direction in the vehicle's frame; likewise",
        lambda view, v: view.seen.lane_poly[v, 1],
        _seen_lane,
    ),
    "camera_curvature_per_m": Column(
        pa.float32(), "2·C2, 1/m, left positive; likewise", lambda view, v: 2.0 * view.seen.lane_poly[v, 2], _seen_lane
    ),
    "camera_sigma_m": Column(
        pa.float32(),
        "standard deviation that the camera states, m; likewise",
        lambda view, v: view.seen.camera_sigma_m[v],
        _seen_lane,
    ),
    "speed_mps": Column(pa.float32(), "odometer, m/s", lambda view, v: view.seen.speed_mps[v]),
    "yaw_rate_rps": Column(pa.float32(), "gyro, rad/s, left positive", lambda view, v: view.seen.yaw_rate_rps[v]),
    "heading_rad": Column(
        pa.float32(),
        "yaw as the vehicle knows it, rad, counter-clockwise from east",
        lambda view, v: view.seen.heading_rad[v],
    ),
    "true_east_m": Column(pa.float64(), "*truth*: rear axle, m east", lambda view, v: view.vehicles.rear_m[v, 0]),
    "true_north_m": Column(pa.float64(), "*truth*: the same, m north", lambda view, v: view.vehicles.rear_m[v, 1]),
    "true_yaw_rad": Column(pa.float32(), "*truth*: of the body, rad", lambda view, v: view.vehicles.yaw_rad[v]),
    "true_speed_mps": Column(pa.float32(), "*truth*: of the axle, m/s", lambda view, v: view.vehicles.speed_mps[v]),
    "true_lane_offset_m": Column(
        pa.float32(),
        "*truth*: from the lane's centre, m, left positive",
        lambda view, v: view.vehicles.lane_offset_m[v],
    ),
    "estimate_east_m": Column(
        pa.float64(), "of an undefended EKF, m east", lambda view, v: view.answers.estimate_m[view.rows, 0, 0]
    ),
    "estimate_north_m": Column(
        pa.float64(), "the same, m north", lambda view, v: view.answers.estimate_m[view.rows, 0, 1]
    ),
}
"""The columns that vary, in their order; names of vehicle and attack come before them."""


class DatasetLog(ParquetLog):
    """Writes a file of the dataset as a run goes on; implements `gpsec.pipeline.interfaces.Onlooker`."""

    def __init__(self, path: Path) -> None:
        """Begin the file, which has its name once the block has succeeded."""
        names = [("vehicle", _NAME), ("attack", _NAME)]
        numbers = [name for name, one in MEASURED.items() if pa.types.is_floating(one.kind)]
        super().__init__(
            path,
            pa.schema([*names, *((name, one.kind) for name, one in MEASURED.items())]),
            use_dictionary=["vehicle", "attack"],
            use_byte_stream_split=numbers,  # a third smaller
        )
        self._attacks: list[str] = []

    def begin(self, study: Study) -> None:
        """Learn the names of the attacks."""
        self._attacks = list(study.plans)

    def see(self, view: StepView, outcomes: OutcomeState, fleet: Mapping[int, Identity]) -> None:
        """Take in a step."""
        v = view.tracks.vehicle[view.rows]
        step: dict[str, Any] = {name: one.values(view, v) for name, one in MEASURED.items()}
        step |= {f"?{name}": one.known(view, v) for name, one in MEASURED.items() if one.known is not None}
        step["vehicle"] = np.array([fleet[row].vehicle_id for row in v.tolist()], object)
        step["attack"] = np.array(self._attacks, object)[view.tracks.plan[view.rows]]
        self._hold(step, len(v))

    def _columns(self, data: Mapping[str, Any]) -> list[Any]:
        columns = [pa.array(data["vehicle"]).dictionary_encode(), pa.array(data["attack"]).dictionary_encode()]
        for name, one in MEASURED.items():
            mask = ~data[f"?{name}"] if one.known is not None else None
            columns.append(pa.array(data[name].astype(one.kind.to_pandas_dtype()), type=one.kind, mask=mask))
        return columns
