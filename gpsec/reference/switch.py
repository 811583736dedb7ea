"""The switch between GNSS and isolation, for one track: plain objects, one for each defence."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, inf, sin, sqrt

import numpy as np

from gpsec.arrays import Floats
from gpsec.errors import GpsecError, nearest
from gpsec.localization.noise_table import FilterNoise
from gpsec.localization.switch import SwitchSettings
from gpsec.reference.filters import CameraUkf, GnssEkf, wrapped
from gpsec.reference.matching import Road
from gpsec.reference.sight import Sight

RESPONSES = ("none", "dead_reckoning", "ukf")
_SIGMAS = 3.0
_YAW_SIGMAS = 4.0
_ALONG_SLACK_M = 1.0
_LOST_PERIODS = 2.5


@dataclass(frozen=True)
class Rules:
    """What the switch of a vehicle goes by.

    Attributes:
        noise: figures of its sensors.
        settings: when GNSS is given up and taken back.
        step_s: length of a step.

    """

    noise: FilterNoise
    settings: SwitchSettings
    step_s: float

    @property
    def outage_s(self) -> float:
        """Without a fix for longer than this, GNSS is lost."""
        return max(self.settings.outage_s, _LOST_PERIODS * self.noise.gnss_period_s)


class Navigator:
    """One defence of one track: an EKF while GNSS is trusted, a UKF while it is isolated."""

    def __init__(self, response: str, rules: Rules, fix_m: Floats, heading_rad: float) -> None:
        self.response = response
        self._rules = rules
        self.ekf: GnssEkf | None = GnssEkf.at_first_fix(rules.noise, fix_m, heading_rad)
        self.ukf: CameraUkf | None = None
        self.corrected = False
        self._quiet_s = 0.0
        self._consistent_s = 0.0
        self._way_m = 0.0

    @property
    def isolated(self) -> bool:
        """GNSS is not used."""
        return self.ukf is not None

    @property
    def position_m(self) -> Floats:
        """The (2,) estimate."""
        return (self.ekf or self.ukf).mean[:2]  # type: ignore[union-attr]

    def step(self, sight: Sight, alarm: bool, lost: bool, residual_m: float | None, road: Road) -> None:
        """Take one step."""
        if self.ekf is not None and self.response != "none" and (alarm or lost):
            self._isolate(self.ekf, sight, lost)
        step_s = self._rules.step_s
        if self.ekf is not None:
            self.ekf.predict(sight.speed_mps, sight.yaw_rate_rps, step_s)
            if sight.fix_m is not None:
                self.ekf.update(sight.fix_m)
        elif self.ukf is not None:
            self.ukf.predict(sight.speed_mps, sight.yaw_rate_rps, step_s)
            self._way_m += abs(sight.speed_mps) * step_s
            self.corrected = False
            if self.response == "ukf" and sight.lane_offset_m is not None:
                self.corrected = self.ukf.update(road, sight.lane, sight.lane_offset_m, sight.camera_sigma_m)
            self._quiet_s = 0.0 if alarm or lost else self._quiet_s + step_s
            if lost:
                self._consistent_s = 0.0
            if sight.fix_m is not None and residual_m is not None:
                self._consider(self.ukf, sight.fix_m, residual_m)

    def _isolate(self, ekf: GnssEkf, sight: Sight, lost: bool) -> None:
        mean, P = ekf.mean, ekf.covariance
        yaw, variance, sigma = float(mean[2]), float(P[2, 2]), self._rules.noise.heading_rad
        # Where spoofed fixes have turned the filter, the heading sensor's yaw of one step ago is better.
        heading = sight.heading_rad - sight.yaw_rate_rps * self._rules.step_s
        if not lost and abs(wrapped(yaw - heading)) > _YAW_SIGMAS * sigma:
            yaw, variance = heading, sigma**2
        self.ukf = CameraUkf(self._rules.noise, mean[:2].copy(), P[:2, :2].copy(), yaw, variance)
        self.ekf = None
        self._quiet_s = self._consistent_s = self._way_m = 0.0

    def _consider(self, ukf: CameraUkf, fix_m: Floats, residual_m: float) -> None:
        """Compare a fix with what the vehicle knows; take GNSS back where it has agreed for long enough."""
        noise, settings, half = self._rules.noise, self._rules.settings, self._rules.step_s / 2.0
        ahead = np.array([cos(ukf.yaw_rad), sin(ukf.yaw_rad)])
        along = float(ahead @ (fix_m - ukf.mean))
        drift = (noise.odometer_scale * self._way_m) ** 2
        variance = float(ahead @ ukf.covariance @ ahead) + drift + noise.gnss_white_m**2 + noise.gnss_bias_m**2
        lateral_agrees = abs(residual_m) <= _SIGMAS * noise.residual_m
        along_agrees = abs(along) - _ALONG_SLACK_M <= _SIGMAS * sqrt(variance)
        if lateral_agrees and along_agrees:
            self._consistent_s += max(noise.gnss_period_s, self._rules.step_s)
        else:
            self._consistent_s = 0.0
        if self._quiet_s >= settings.hold_s - half and self._consistent_s >= settings.rejoin_s - half:
            P = np.zeros((5, 5))
            P[:2, :2] = ukf.covariance + (drift + along**2) * np.outer(ahead, ahead)
            P[2, 2] = ukf.yaw_variance
            P[3, 3] = P[4, 4] = noise.gnss_bias_m**2
            self.ekf = GnssEkf(noise, np.array([*ukf.mean, ukf.yaw_rad, 0.0, 0.0]), P)
            self.ukf = None


class Helm:
    """All defences of one track.

    Attributes:
        navigators: one for each defence; none before the first fix.

    """

    def __init__(self, detectors: Sequence[int], responses: Sequence[str], rules: Rules) -> None:
        for response in responses:
            if response not in RESPONSES:
                known = nearest(response, RESPONSES)
                raise GpsecError(f"the reference engine has no response '{response}': {known}")
        self.navigators: list[Navigator] = []
        self._detectors = list(detectors)
        self._responses = list(responses)
        self._rules = rules
        self._fix_age_s = inf

    def step(self, sight: Sight, alarms: Sequence[bool], residual_m: float | None, road: Road) -> None:
        """Take one step; `alarms` are those of the detectors."""
        if not self.navigators:
            if sight.fix_m is not None:
                self._fix_age_s = 0.0
                self.navigators = [
                    Navigator(response, self._rules, sight.fix_m, sight.heading_rad) for response in self._responses
                ]
            return
        self._fix_age_s = 0.0 if sight.fix_m is not None else self._fix_age_s + self._rules.step_s
        lost = self._fix_age_s > self._rules.outage_s
        for navigator, detector in zip(self.navigators, self._detectors, strict=True):
            navigator.step(sight, alarms[detector], lost, residual_m, road)
