"""What a vehicle's sensors are good for: rates, latencies, noise, biases and outages, each figure with its source.

All figures are one standard deviation of one axis. A channel's error is white noise, drawn anew for each sample,
plus a first-order Gauss-Markov bias of standard deviation σ and correlation time τ. Outages begin at random with
a mean rate and last exponentially long; ``outage_mean_s = 0`` makes each last a single step.
"""

from collections.abc import Mapping
from math import exp, sqrt
from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from gpsec.sensors.canyons import rms_m
from gpsec.sensors.smooth import Wander

_WANDER = ("wander_mps", "wander_tau_s", "wander_hold_s")
_MULTIPATH = ("multipath_m", "multipath_spread", "multipath_length_m")
_TAILS = ("tail_share", "tail_factor")
_WRONG_LINE = ("wrong_line_per_h", "wrong_line_mean_s", "wrong_line_m")


def _require_together(model: BaseModel, keys: tuple[str, ...]) -> None:
    """Refuse some of the figures that mean something together only."""
    given = [key for key in keys if getattr(model, key) is not None]
    if given and len(given) < len(keys):
        raise ValueError(f"expected {', '.join(keys)} together, found {', '.join(given)}")


class Sourced(BaseModel):
    """Numbers that must each say where they come from.

    Attributes:
        sources: figure (field name) -> publication, data sheet, or the assumption that was made.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
    sources: Mapping[str, str]

    def figures(self) -> dict[str, float]:
        """Return the value of every figure by its name."""
        return {name: value for name, value in self if isinstance(value, int | float)}

    @model_validator(mode="after")
    def _every_figure_has_a_source(self) -> Self:
        if missing := sorted(set(self.figures()) - {name for name, text in self.sources.items() if text.strip()}):
            raise ValueError(f"no source given for {', '.join(missing)}")
        if unknown := sorted(set(self.sources) - set(self.figures())):
            raise ValueError(f"source given for {', '.join(unknown)}, which is no figure of this channel")
        return self


class Channel(Sourced):
    """What every channel has.

    Attributes:
        rate_hz: samples per second; the loop uses at most one a step.
        latency_s: age of what a sample describes when it arrives.
        outages_per_h: mean number of outages that begin in an hour.
        outage_mean_s: mean length of an outage.
    """

    rate_hz: float = Field(gt=0.0, le=10_000.0)
    latency_s: float = Field(ge=0.0, le=1.0)
    outages_per_h: float = Field(ge=0.0, le=36_000.0)
    outage_mean_s: float = Field(ge=0.0, le=3_600.0)


class Gnss(Channel):
    """Position fix, per horizontal axis.

    Attributes:
        white_m: white noise of a fix.
        bias_m, bias_tau_s: slow error (atmosphere, orbits, multipath, map alignment of a fused pose).
        wander_mps, wander_tau_s, wander_hold_s: the slow error wanders smoothly instead (`gpsec.sensors.smooth`): σ and
            correlation time of its rate, and time constant of the leak that holds it.
        multipath_m, multipath_spread, multipath_length_m: the slow error depends on the place
            (`gpsec.sensors.canyons`): σ of an axis in a middling place, standard deviation of its logarithm among
            places, and how far apart places are. What wander and multipath leave of `bias_m` is constant for a
            journey; `bias_tau_s` is then what filters take for the whole.
        common_share: share of the variance of the slow error, but for multipath, that all receivers in a run have in
            common.
    """

    white_m: float = Field(ge=0.0, le=100.0)
    bias_m: float = Field(ge=0.0, le=100.0)
    bias_tau_s: float = Field(gt=0.0, le=1e6)
    wander_mps: float | None = Field(None, gt=0.0, le=10.0)
    wander_tau_s: float | None = Field(None, gt=0.0, le=600.0)
    wander_hold_s: float | None = Field(None, gt=0.0, le=1e5)
    multipath_m: float | None = Field(None, gt=0.0, le=100.0)
    multipath_spread: float | None = Field(None, ge=0.0, le=1.0)
    multipath_length_m: float | None = Field(None, ge=1.0, le=1000.0)
    common_share: float | None = Field(None, gt=0.0, le=1.0)

    @property
    def wander(self) -> Wander | None:
        """The smooth wander, None where the slow error is a Gauss-Markov bias."""
        if self.wander_mps is None or self.wander_tau_s is None or self.wander_hold_s is None:
            return None
        return Wander(self.wander_mps, self.wander_tau_s, self.wander_hold_s)

    @property
    def offset_m(self) -> float:
        """Standard deviation of what is constant for a journey beside wander and multipath."""
        return sqrt(max(self.bias_m**2 - self._moving_m2, 0.0))

    @property
    def is_lasting(self) -> bool:
        """Whether what is left of the slow error beside wander and multipath is constant for a journey."""
        return self.wander is not None or self.multipath_m is not None

    @property
    def shared_m2(self) -> float:
        """Variance that receivers at one place have in common: multipath, and `common_share` of the rest."""
        return self._multipath_m2 + (self.common_share or 0.0) * (self.bias_m**2 - self._multipath_m2)

    @property
    def _multipath_m2(self) -> float:
        return rms_m(self.multipath_m or 0.0, self.multipath_spread or 0.0) ** 2

    @property
    def _moving_m2(self) -> float:
        return self._multipath_m2 + (self.wander.sigma_m**2 if self.wander is not None else 0.0)

    def structure_m2(self, lag_s: float) -> float:
        """Return the mean square of how far the error of an axis goes in a lag: 2·white² and that of the slow error."""
        if self.wander is not None and self.multipath_m is None:
            slow_m2 = float(self.wander.structure_m2(np.array([lag_s]))[0])
        else:
            slow_m2 = 2.0 * self.bias_m**2 * (1.0 - exp(-lag_s / self.bias_tau_s))
        return 2.0 * self.white_m**2 + slow_m2

    @model_validator(mode="after")
    def _wander_is_whole(self) -> Self:
        _require_together(self, _WANDER)
        _require_together(self, _MULTIPATH)
        if (moving_m := sqrt(self._moving_m2)) > self.bias_m:
            raise ValueError(f"expected wander and multipath within bias_m = {self.bias_m:g} m, found {moving_m:.3g} m")
        return self


class Gyro(Channel):
    """Yaw rate.

    Attributes:
        angle_random_walk_deg_per_sqrt_h: white noise; the mean over a step dt has σ = ARW/60·π/180/√dt rad/s.
        bias_deg_per_h, bias_tau_s: bias instability.
    """

    angle_random_walk_deg_per_sqrt_h: float = Field(ge=0.0, le=100.0)
    bias_deg_per_h: float = Field(ge=0.0, le=10_000.0)
    bias_tau_s: float = Field(gt=0.0, le=1e6)


class Odometer(Channel):
    """Wheel speed.

    Attributes:
        white_mps: white noise of a sample.
        scale_ratio: spread of the scale error among vehicles, constant for a journey (the limit τ → ∞ of a bias).
    """

    white_mps: float = Field(ge=0.0, le=10.0)
    scale_ratio: float = Field(ge=0.0, le=0.2)


class Heading(Channel):
    """Yaw as the vehicle knows it (dual antenna or INS).

    Attributes:
        white_deg: white noise of a sample.
        bias_deg, bias_tau_s: slow error of the alignment.
    """

    white_deg: float = Field(ge=0.0, le=10.0)
    bias_deg: float = Field(ge=0.0, le=10.0)
    bias_tau_s: float = Field(gt=0.0, le=1e6)


class Camera(Channel):
    """Lane camera that gives C0 … C3 (Eq 1).

    Attributes:
        white_m: white noise of C0 where the whole range is in view, tails included.
        bias_m, bias_tau_s: slow error of C0 (width and wear of the paint, pitch).
        mount_m: spread of the mounting offset among vehicles, constant for a vehicle.
        range_m: length of lane that the polynomial is fitted to.
        field_of_view_deg: horizontal; a curve leaves it before the range ends.
        trust_limit_m: the camera reports no lane when the σ that it states for C0 exceeds this.
        tail_share, tail_factor: share of the samples whose white noise is so many times that of the others.
        slope_correlation: of the white errors of C0 and C1; negative, since C0 is drawn on from paint that is ahead.
        wrong_line_per_h, wrong_line_mean_s, wrong_line_m: times in an hour that a wrong line is taken, how long that
            lasts, and by how much C0 is off meanwhile, to either side; the stated σ says nothing of it.
        visibility: `place`: the lane is also lost where too little of a line lies ahead, before stop lines, and behind
            other vehicles (`gpsec.sensors.visibility`); `clock`: by outages alone.
    """

    white_m: float = Field(ge=0.0, le=10.0)
    bias_m: float = Field(ge=0.0, le=10.0)
    bias_tau_s: float = Field(gt=0.0, le=1e6)
    mount_m: float = Field(ge=0.0, le=1.0)
    range_m: float = Field(ge=5.0, le=200.0)
    field_of_view_deg: float = Field(ge=10.0, le=180.0)
    trust_limit_m: float = Field(gt=0.0, le=10.0)
    tail_share: float | None = Field(None, gt=0.0, lt=1.0)
    tail_factor: float | None = Field(None, ge=1.0, le=100.0)
    slope_correlation: float | None = Field(None, gt=-1.0, lt=1.0)
    wrong_line_per_h: float | None = Field(None, gt=0.0, le=36_000.0)
    wrong_line_mean_s: float | None = Field(None, gt=0.0, le=3_600.0)
    wrong_line_m: float | None = Field(None, gt=0.0, le=10.0)
    visibility: Literal["clock", "place"] = "clock"

    @model_validator(mode="after")
    def _faults_are_whole(self) -> Self:
        _require_together(self, _TAILS)
        _require_together(self, _WRONG_LINE)
        return self


class SensorProfile(Sourced):
    """The sensors and the HD map of one kind of vehicle.

    Attributes:
        name: by which scenarios and vehicle types choose it.
        title: one line for lists.
        map_spacing_m: spacing of the points that the vehicle's own map has on a lane's centre line.
        gnss, gyro, odometer, heading, camera: the channels.
    """

    name: str = Field(pattern=r"^[a-z][a-z0-9_]*$")
    title: str
    map_spacing_m: float = Field(gt=0.0, le=100.0)
    gnss: Gnss
    gyro: Gyro
    odometer: Odometer
    heading: Heading
    camera: Camera

    def channels(self) -> dict[str, Channel]:
        """Return the five channels by name."""
        return {name: value for name, value in self if isinstance(value, Channel)}


def residual_sigma_m(profile: SensorProfile) -> float:
    """Return σ of the residual z = d_camera - d_map(fix) that a profile promises on a straight marked road.

    The five independent parts are the camera's white noise, bias and mounting offset, and the white noise and
    bias of one axis of the fix. The map is exact on a straight road, whatever its spacing.
    """
    camera, gnss = profile.camera, profile.gnss
    parts = (camera.white_m, camera.bias_m, camera.mount_m, gnss.white_m, gnss.bias_m)
    return sqrt(sum(part * part for part in parts))
