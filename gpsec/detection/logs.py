"""Benign residual sequences, as training and calibration read them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import blake2b
from typing import Any, Self

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.errors import GpsecError
from gpsec.core.tables import Table, taken
from gpsec.detection.base import Observation
from gpsec.detection.channels import Channels, silent_channels
from gpsec.detection.monitor_state import MonitorInputs
from gpsec.filters.noise import FilterNoise

_COLUMNS = ("residual_m", "valid", "speed_mps", "curvature_per_m", "camera_sigma_m")


@dataclass(frozen=True)
class ResidualLog:
    """What one benign run gave for the vehicles of one sensor profile; n samples sorted by vehicle, then step.

    A step of a vehicle that is missing counts as one without a valid residual.

    Attributes:
        network: name of the road network; profile, association: as in the models.
        step_s: length of a step.
        scale_m: standard deviation of the residual that the profile promises.
        vehicle, step: (n,) number of the vehicle within this log, and of the step.
        residual_m, valid, speed_mps, curvature_per_m, camera_sigma_m: (n,) as in `Observation`.
        inputs: (n,) of the monitor; None where nobody reads it.
        figures: of the profile's sensors, as the monitor knows them; likewise.
    """

    network: str
    profile: str
    association: str
    step_s: float
    scale_m: float
    vehicle: Ints
    step: Ints
    residual_m: Floats
    valid: Flags
    speed_mps: Floats
    curvature_per_m: Floats
    camera_sigma_m: Floats
    inputs: MonitorInputs | None = None
    figures: FilterNoise[float] | None = None

    def columns(self) -> list[np.ndarray]:
        """Return the arrays of what was measured, the monitor's inputs last."""
        return [*(getattr(self, name) for name in _COLUMNS), *(self.inputs or ())]

    def select(self, chosen: Flags) -> Self:
        """Return the (n,) chosen samples."""
        columns = ("vehicle", "step", *_COLUMNS)
        inputs = None if self.inputs is None else taken(self.inputs, chosen)
        return replace(self, **{name: getattr(self, name)[chosen] for name in columns}, inputs=inputs)


def split(logs: Sequence[ResidualLog], share: float, seed: int) -> tuple[list[ResidualLog], list[ResidualLog]]:
    """Split every log by vehicles: about `share` of them in the first part, the others in the second.

    Which part a vehicle goes to depends on (seed, network, vehicle) only.
    """
    first, second = [], []
    for log in logs:
        here = np.unique(log.vehicle)
        salt = f"{seed}/{log.network}/".encode()
        draws = [int.from_bytes(blake2b(salt + str(v).encode(), digest_size=4).digest(), "big") for v in here]
        chosen = np.isin(log.vehicle, here[np.asarray(draws, np.int64) < share * 2**32])
        first.append(log.select(chosen))
        second.append(log.select(~chosen))
    return first, second


@dataclass(frozen=True)
class Grid:
    """The logs of one profile and association side by side, each vehicle from its first step; T steps, V vehicles.

    Vehicles are sorted by the length of their sequence, the longest first.

    Attributes:
        step_s: length of a step.
        length: (V,) steps of a vehicle.
        scale_m: (V,) see `ResidualLog`.
        residual_m, valid, speed_mps, curvature_per_m, camera_sigma_m: (T, V).
        inputs, figures: (T, V) and of the sensors, see `ResidualLog`.
        channels: (T, V) what the monitor says; None where it has not run (`gpsec.detection.monitored`).
    """

    step_s: float
    length: Ints
    scale_m: Floats
    residual_m: Floats
    valid: Flags
    speed_mps: Floats
    curvature_per_m: Floats
    camera_sigma_m: Floats
    inputs: MonitorInputs | None = None
    figures: FilterNoise[float] | None = None
    channels: Channels | None = None

    @classmethod
    def of(cls, logs: Sequence[ResidualLog]) -> Self:
        """Lay out logs, which must have one profile, association and step length.

        Raises:
            GpsecError: they differ, are empty or not sorted.
        """
        kinds = {(log.profile, log.association, log.step_s) for log in logs}
        if len(kinds) != 1:
            raise GpsecError(f"residual logs: expected one profile, association and step length, found {sorted(kinds)}")
        starts, lengths, scales = [], [], []
        for log in logs:
            order = np.lexsort((log.step, log.vehicle))
            if not np.array_equal(order, np.arange(len(order))):
                raise GpsecError(f"residual log of {log.network}: expected samples sorted by vehicle, then step")
            _, start, count = np.unique(log.vehicle, return_index=True, return_counts=True)
            starts.append(start)
            lengths.append(log.step[start + count - 1] - log.step[start] + 1 if len(start) else start)
            scales.append(np.full(len(start), log.scale_m))
        length = np.concatenate(lengths).astype(np.int32)
        if not len(length):
            raise GpsecError(f"residual logs of profile '{logs[0].profile}': expected vehicles, found none")
        order = np.argsort(-length, kind="stable")
        column = np.empty(len(order), np.int64)
        column[order] = np.arange(len(order))
        shape = (int(length.max()), len(length))
        grid = cls(
            step_s=logs[0].step_s,
            length=length[order],
            scale_m=np.concatenate(scales)[order],
            residual_m=np.zeros(shape),
            valid=np.zeros(shape, np.bool_),
            speed_mps=np.zeros(shape),
            curvature_per_m=np.zeros(shape),
            camera_sigma_m=np.zeros(shape),
            inputs=None if any(log.inputs is None for log in logs) else _no_inputs(shape),
            figures=logs[0].figures,
        )
        before = 0
        for log, start in zip(logs, starts, strict=True):
            own = np.cumsum(np.bincount(start, minlength=len(log.vehicle))) - 1 if len(start) else start
            at: tuple[Any, Any] = (log.step - log.step[start][own], column[before + own]) if len(start) else ([], [])
            for target, source in zip(grid.columns(), log.columns(), strict=False):
                target[at] = source
            before += len(start)
        return grid

    @classmethod
    def joined(cls, grids: Sequence[Self]) -> Self:
        """Return the vehicles of one or more grids of one kind, side by side."""
        length = np.concatenate([grid.length for grid in grids])
        order = np.argsort(-length, kind="stable")

        def beside(*parts: np.ndarray) -> Any:
            whole = np.zeros((max(map(len, parts)), len(length)), parts[0].dtype)
            first = 0
            for part in parts:
                whole[: len(part), first : first + part.shape[1]] = part
                first += part.shape[1]
            return whole[:, order]

        inputs = [grid.inputs for grid in grids if grid.inputs is not None]
        channels = [grid.channels for grid in grids if grid.channels is not None]
        return replace(
            grids[0],
            length=length[order],
            scale_m=np.concatenate([grid.scale_m for grid in grids])[order],
            inputs=MonitorInputs._make(map(beside, *inputs)) if len(inputs) == len(grids) else None,
            channels=Channels._make(map(beside, *channels)) if len(channels) == len(grids) else None,
            **{name: beside(*(getattr(grid, name) for grid in grids)) for name in _COLUMNS},
        )

    def columns(self) -> list[np.ndarray]:
        """Return the arrays of what was measured, the monitor's inputs last."""
        return [*(getattr(self, name) for name in _COLUMNS), *(self.inputs or ())]

    @cached_property
    def elapsed_steps(self) -> Ints:
        """(T, V) as in `Observation`."""
        number = np.arange(1, len(self.valid) + 1, dtype=np.int32)[:, np.newaxis]
        last = np.maximum.accumulate(np.where(self.valid, number, np.int32(0)), axis=0)
        elapsed = np.broadcast_to(number, last.shape).copy()
        elapsed[1:] -= last[:-1]
        return elapsed

    def active(self, step: int) -> int:
        """Return how many vehicles have a sequence longer than `step`: the first ones."""
        return int(np.searchsorted(-self.length, -step, side="left"))

    def select(self, chosen: Flags) -> Self:
        """Return the (V,) chosen vehicles."""
        length = self.length[chosen]
        steps = int(length.max(initial=0))
        columns = {name: getattr(self, name)[:steps, chosen] for name in _COLUMNS}
        inputs = self.inputs and MonitorInputs._make(array[:steps, chosen] for array in self.inputs)
        channels = self.channels and Channels._make(array[:steps, chosen] for array in self.channels)
        told: dict[str, Any] = {"inputs": inputs, "channels": channels}
        return replace(self, length=length, scale_m=self.scale_m[chosen], **told, **columns)

    def observe(self, step: int) -> Observation:
        """Return one step of the active vehicles; vehicle v owns row v."""
        m = self.active(step)
        told = self.channels
        channels = silent_channels((m,)) if told is None else Channels._make(array[step, :m] for array in told)
        return Observation(
            rows=np.arange(m, dtype=np.int32),
            profile=np.zeros(m, np.int32),
            residual_m=self.residual_m[step, :m],
            valid=self.valid[step, :m],
            elapsed_steps=self.elapsed_steps[step, :m],
            scale_m=self.scale_m[:m],
            speed_mps=self.speed_mps[step, :m],
            curvature_per_m=self.curvature_per_m[step, :m],
            camera_sigma_m=self.camera_sigma_m[step, :m],
            channels=channels,
            step_s=self.step_s,
            unmatched=np.zeros(m, np.bool_),
        )


def _no_inputs(shape: tuple[int, ...]) -> MonitorInputs:
    return MonitorInputs._make(np.zeros(shape, array.dtype) for array in Table(MonitorInputs).now)


def sessions(grid: Grid, gap_steps: int) -> list[tuple[int, Ints]]:
    """Return (vehicle, steps with a valid residual) of every stretch without a gap longer than `gap_steps`."""
    found = []
    for vehicle in range(len(grid.length)):
        steps = np.flatnonzero(grid.valid[:, vehicle]).astype(np.int32)
        cuts = np.flatnonzero(np.diff(steps) > gap_steps) + 1
        found += [(vehicle, piece) for piece in np.split(steps, cuts) if len(piece)]
    return found
