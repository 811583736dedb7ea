"""The sections `traffic`, `localization` and `outcomes` of `gpsec.toml`: keys, types, bounds and defaults."""

from typing import Annotated

from pydantic import Field, field_validator

from gpsec.attacks.plans import MAX_TIME_S
from gpsec.scenario.base import Section, Unset


class TrafficSection(Section):
    """How SUMO is run.

    Attributes:
        begin_s: simulated time at which SUMO begins, such as that of the rush hour; unset takes the sumocfg's.
        step_s: seconds of a step, since the filters are not valid for long ones; unset takes 0.1, or the sumocfg's
            where that is shorter.
        lateral_resolution_m: metres of SUMO's sublanes, at least 0.1; unset takes the sumocfg's, or 0.8 where it has
            none; 0 turns them off, and lane changes then take one step.
    """

    begin_s: Annotated[float | None, Unset] = Field(None, ge=0.0, le=MAX_TIME_S)
    # The filters are not valid for longer steps.
    step_s: Annotated[float | None, Unset] = Field(None, ge=0.001, le=0.2)
    lateral_resolution_m: Annotated[float | None, Unset] = Field(None, ge=0.0, le=5.0)

    @field_validator("lateral_resolution_m")
    @classmethod
    def _not_too_fine(cls, width_m: float | None) -> float | None:
        # SUMO would go through thousands of sublanes for every vehicle.
        if width_m is not None and 0.0 < width_m < 0.1:
            raise ValueError(f"expected 0 (off), or 0.1 to 5, found {width_m:g}")
        return width_m


class LocalizationSection(Section):
    """When the vehicle stops and starts to use GNSS again.

    Attributes:
        hold_s: seconds that GNSS stays isolated after the last alarm.
        rejoin_s: seconds that fixes must agree with the estimate before they are used again.
        outage_s: seconds without a fix after which a vehicle counts as without GNSS.
        rollback_s: seconds before the alarm, at least, from which `rollback` and `ukf5_rollback` restart.
    """

    hold_s: float = Field(2.0, ge=0.0, le=600.0)
    rejoin_s: float = Field(1.0, ge=0.0, le=600.0)
    outage_s: float = Field(0.5, ge=0.0, le=600.0)
    # Where an attack grows slowly, the detectors' mean delay is 5 to 6.5 s (README.md).
    rollback_s: float = Field(6.0, ge=0.0, le=60.0)


class OutcomesSection(Section):
    """How results are summed up.

    Attributes:
        bootstrap: resamples (of vehicles) behind every interval.
        confidence: of the intervals.
    """

    bootstrap: int = Field(1000, ge=1, le=100_000)
    confidence: float = Field(0.95, gt=0.0, lt=1.0)
