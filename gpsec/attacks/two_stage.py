"""Two-stage attack on a fusion filter: FusionRipper."""

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from gpsec.attacks.base import Attack, Spoofed, Victims, displace_left, powers, random_signs
from gpsec.core.arrays import Floats, Ints
from gpsec.core.tables import blank


class TwoStageState(NamedTuple):
    """The stage of M tracks.

    Attributes:
        trigger_step: (M,) step in which the second stage began, -1 before.
    """

    trigger_step: Ints = blank(-1)


class TwoStage(Attack):
    """A constant displacement until the victim gives way, then an exponential one: d, then d·fⁱ.

    FusionRipper (Shen, Won, Chen and Chen, "Drift with Devil: Security of Multi-Sensor Fusion based Localization in
    High-Level Autonomous Driving under GPS Spoofing", USENIX Security 2020). Stage one, *vulnerability profiling*,
    displaces the fixes sideways by d and watches the victim. Once it deviates to that side, its filter has come to
    trust GNSS, and stage two, *aggressive spoofing*, displaces by d·fⁱ, with i = 1, 2, … counting its GNSS updates.

    Attributes:
        d_m: d; 0.3-2.0 m is the published range.
        f: growth from one GNSS update to the next; 1.1-2.0 is the published range.
        trigger_m: deviation of the undefended estimate towards the attack's side that begins stage two. The default
            is that at which a 2.11 m wide vehicle touches the line of a 2.7 m wide lane.
        timeout_s: stage two begins after so long in any case.
        update_s: time between two GNSS updates as i counts them, at least one step.
        cap_m: largest displacement.
        side: side of the lane to which the fixes are moved; `random` is left for half of the vehicles.
    """

    name: ClassVar[str] = "two_stage"
    state: ClassVar[type[Any]] = TwoStageState
    d_m: float = Field(0.5, ge=0.3, le=2.0)
    f: float = Field(1.5, ge=1.1, le=2.0)
    trigger_m: float = Field(0.295, gt=0.0, le=10.0)
    timeout_s: float = Field(10.0, ge=0.0, le=10_000.0)
    update_s: float = Field(1.0, gt=0.0, le=10.0)
    cap_m: float = Field(10.0, gt=0.0, le=10_000.0)
    side: Literal["left", "right", "random"] = "random"

    def spoof(self, victims: Victims, state: TwoStageState) -> Spoofed:
        """Return fix + side·d in stage one, fix + side·min(d·fⁱ, cap) in stage two."""
        sign = self._signs(victims)
        begun = state.trigger_step[victims.rows]
        gives_way = (sign * victims.deviation_m >= self.trigger_m) | (victims.elapsed_s >= self.timeout_s)
        begun = np.where((begun < 0) & gives_way, victims.step, begun)
        state.trigger_step[victims.rows] = begun
        update_steps = max(1, round(self.update_s / victims.step_s))
        i = np.where(begun < 0, 0, 1 + (victims.step - begun) // update_steps).astype(np.float64)
        return displace_left(victims, sign * np.minimum(self.d_m * powers(self.f, i), self.cap_m))

    def _signs(self, victims: Victims) -> Floats:
        if self.side == "random":
            return random_signs(victims)
        return np.full(len(victims.rows), 1.0 if self.side == "left" else -1.0)
