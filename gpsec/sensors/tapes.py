"""Tapes in the place of a profile's white noise, bias and outages."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import floor

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.errors import GpsecError
from gpsec.core.kernels import inline, kernel
from gpsec.core.noise import CAMERA_TAPE, GNSS_TAPE, uniform
from gpsec.core.threads import Threads
from gpsec.sensors.canyons import NO_MULTIPATH
from gpsec.sensors.faults import NO_FAULTS
from gpsec.sensors.mismatch import Mismatch
from gpsec.sensors.profiles import Channel, SensorProfile
from gpsec.sensors.sense_kernels import CONSTANT
from gpsec.sensors.smooth import NO_WANDER
from gpsec.sensors.table import BIAS, DECAY, KICK, OUTAGE_BEGIN, TRUST, WHITE, ProfileTable
from gpsec.sensors.tape_loop import TapeLoop, make_loop
from gpsec.types.tapes import Tape
from gpsec.types.vehicles import Measurements, Vehicles


@inline
def tape_place(key: np.uint64, channel: int, step: int, per_step: float, length: int) -> int:
    """Return which sample of a loop a vehicle is at: it began anywhere, and goes on by `per_step` samples a step."""
    begin = uniform(key, channel, CONSTANT) * length
    return floor(begin + step * per_step) % length


@kernel
def play_fixes(
    rows: Ints, step: int, per_step: float, truth: Vehicles, loop: TapeLoop, factor: float, out: Measurements
) -> None:
    """Add a receiver's tape to the fixes of this step; a fix that the tape has not is not valid."""
    for row in rows:
        at = tape_place(truth.key[row], GNSS_TAPE, step, per_step, len(loop.missing))
        if loop.missing[at]:
            out.fix_valid[row] = False
        if out.fix_valid[row]:
            out.fix_m[row, 0] += factor * loop.errors[at, 0]
            out.fix_m[row, 1] += factor * loop.errors[at, 1]


@kernel
def play_lanes(
    rows: Ints,
    step: int,
    per_step: float,
    truth: Vehicles,
    loop: TapeLoop,
    camera: Floats,
    factor: float,
    out: Measurements,
) -> None:
    """Add a camera's tape to the lanes of this step; one that the tape has not, or that is not trusted, is not seen."""
    for row in rows:
        at = tape_place(truth.key[row], CAMERA_TAPE, step, per_step, len(loop.missing))
        if loop.missing[at] or loop.sigma_m[at] > camera[truth.profile[row], TRUST]:
            out.camera_valid[row] = False
        if out.camera_valid[row]:
            for k in range(4):
                out.lane_poly[row, k] += factor * loop.errors[at, k]
            out.camera_sigma_m[row] = loop.sigma_m[at]


@dataclass(frozen=True)
class Tapes:
    """The tapes of a run.

    Attributes:
        gnss: of receivers, None where fixes are the profile's.
        camera: of lane cameras, None where lanes are the profile's.
    """

    gnss: Tape | None = None
    camera: Tape | None = None

    @cached_property
    def gnss_loop(self) -> TapeLoop | None:
        """The receivers' tape as a loop."""
        return None if self.gnss is None else make_loop(self.gnss)

    @cached_property
    def camera_loop(self) -> TapeLoop | None:
        """The cameras' tape as a loop."""
        return None if self.camera is None else make_loop(self.camera)

    def applied(self, table: ProfileTable) -> ProfileTable:
        """Return the table of what sensors do beside their tapes: white noise, outages and what changes are theirs.

        The bias of a receiver stays as an offset that is constant for a journey, and the mounting of a camera, too:
        both are what a tape has been freed of (its pieces' medians).
        """
        made = ProfileTable(*(channel.copy() for channel in table))
        if self.gnss is not None:
            made.gnss[:, [WHITE, KICK, OUTAGE_BEGIN]] = 0.0
            made.gnss[:, DECAY] = 1.0
            made.wander[:] = NO_WANDER
            made.multipath[:] = NO_MULTIPATH
        if self.camera is not None:
            made.camera[:, [WHITE, BIAS, KICK, OUTAGE_BEGIN]] = 0.0
            made.faults[:] = NO_FAULTS
        return made

    def play(
        self,
        rows: Ints,
        step: int,
        step_s: float,
        vehicles: Vehicles,
        table: ProfileTable,
        mismatch: Mismatch,
        out: Measurements,
        threads: Threads,
    ) -> None:
        """Add the tapes to what was sensed in this step."""
        if self.gnss is not None:
            per_step, factor = samples_per_step(self.gnss, step_s), mismatch.gnss_slow
            threads.run(play_fixes, rows, step, per_step, vehicles, self.gnss_loop, factor, out)
        if self.camera is not None:
            per_step, factor = samples_per_step(self.camera, step_s), mismatch.camera
            threads.run(play_lanes, rows, step, per_step, vehicles, self.camera_loop, table.camera, factor, out)


NO_TAPES = Tapes()


def samples_per_step(tape: Tape, step_s: float) -> float:
    """Return how many samples of a tape a step takes; what is a whole number but for rounding is one."""
    per_step = tape.rate_hz * step_s
    whole = round(per_step)
    return float(whole) if abs(per_step - whole) < 1e-9 * max(whole, 1) else per_step


def check_tape(tape: Tape, name: str, kind: str, profiles: Sequence[SensorProfile], step_s: float) -> None:
    """Refuse a tape that cannot be played for these profiles.

    Args:
        tape: to be played.
        name: of its file, for messages.
        kind: that it should be of.
        profiles: of the run.
        step_s: length of a step.

    Raises:
        GpsecError: it is of another sensor, or has fewer samples a second than the sensors give.
    """
    if tape.kind != kind:
        raise GpsecError(f"{name}: expected a tape of kind '{kind}', found one of kind '{tape.kind}'")
    for profile in profiles:
        channel: Channel = profile.gnss if kind == "gnss" else profile.camera
        needed_hz = min(channel.rate_hz, 1.0 / step_s)
        if tape.rate_hz < needed_hz * (1.0 - 1e-6):
            raise GpsecError(
                f"{name}: rate_hz: expected {needed_hz:g} or more, at which profile '{profile.name}' has samples, found"
                f" {tape.rate_hz:g}"
            )
