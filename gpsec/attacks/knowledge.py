"""What an attacker knows of its victims: the fixes of a while ago, and how far they have been led off."""

from collections.abc import Callable
from math import ceil, cos, sin
from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.core.tables import Table, blank
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Vehicles


class FixHistory(NamedTuple):
    """A ring of the last S steps for each of N vehicle rows; step k stands in column k mod S.

    Attributes:
        fix_m: (N, S, 2) latest honest fix in the net's frame as of that step.
        valid: (N, S) the vehicle had had one by then.
    """

    fix_m: Floats = blank(0.0, "steps", 2)
    valid: Flags = blank(False, "steps")


def new_history(capacity: int, memory_s: float, step_s: float) -> Table[FixHistory]:
    """Return `capacity` rows that reach `memory_s` back."""
    return Table(FixHistory, capacity, steps=ceil(memory_s / step_s - 1e-6) + 1)


def past_fixes(history: FixHistory, rows: Ints, step: int, step_s: float) -> Callable[[float], tuple[Floats, Flags]]:
    """Return `Victims.past_fix` for (m,) vehicle rows, after `record_fixes` of that step."""

    def past_fix(delay_s: float) -> tuple[Floats, Flags]:
        steps, reach = ceil(delay_s / step_s - 1e-6), history.valid.shape[1] - 1
        if not 0 <= steps <= reach:
            raise ValueError(f"a fix of {delay_s} s ago was asked for, but the memory is {reach * step_s:g} s long")
        column = (step - steps) % (reach + 1)
        return history.fix_m[rows, column], history.valid[rows, column]

    return past_fix


@kernel
def record_fixes(rows: Ints, step: int, fix_m: Floats, fix_valid: Flags, history: FixHistory) -> None:
    """Take in the honest fixes of a step, for all vehicle `rows` on the road, in every step.

    Args:
        rows: (n,) vehicle rows; those that departed in this step have been reset.
        step: number of the step.
        fix_m: (N, 2) fixes of all vehicle rows.
        fix_valid: (N,) there is one in this step.
        history: column step mod S gets this step's fix, or the one before it where there is none.
    """
    now = step % history.valid.shape[1]
    before = (step - 1) % history.valid.shape[1]
    for row in rows:
        if fix_valid[row]:
            history.fix_m[row, now, 0] = fix_m[row, 0]
            history.fix_m[row, now, 1] = fix_m[row, 1]
            history.valid[row, now] = True
        else:
            history.fix_m[row, now, 0] = history.fix_m[row, before, 0]
            history.fix_m[row, now, 1] = history.fix_m[row, before, 1]
            history.valid[row, now] = history.valid[row, before]


@kernel
def note_deviation(rows: Ints, tracks: Tracks, vehicles: Vehicles, estimate_m: Floats) -> None:
    """Set the cross-track error of the undefended estimate, defence 0 of (M, D, 2), for track rows under attack.

    The attacker is taken to know it.
    """
    for row in rows:
        if tracks.attacked[row]:
            v = tracks.vehicle[row]
            yaw = vehicles.lane_yaw_rad[v]
            x = estimate_m[row, 0, 0] - vehicles.rear_m[v, 0]
            y = estimate_m[row, 0, 1] - vehicles.rear_m[v, 1]
            tracks.deviation_m[row] = cos(yaw) * y - sin(yaw) * x
