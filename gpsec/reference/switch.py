"""The switch between GNSS and isolation, for one track: plain objects, one for each defence."""

from collections.abc import Sequence
from math import cos, inf, sin, sqrt

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, nearest
from gpsec.reference.considering import ConsideringEkf
from gpsec.reference.filters import GnssEkf, PositionUkf
from gpsec.reference.history import Rules, SightHistory, heading_before, isolated
from gpsec.reference.learning import GatedEkf, LaneUkf, LearningEkf
from gpsec.reference.matching import LaneMatcher
from gpsec.reference.pairing import Residual
from gpsec.reference.sight import Sight
from gpsec.types.tracks import SAMPLE_S

REFERENCE_RESPONSES = (
    "none",
    "gate",
    "dead_reckoning",
    "ukf",
    "rollback",
    "consider_ukf",
    "ukf5",
    "ukf5_rollback",
)
_TRUSTING = ("none", "gate")
_SIGMAS = 3.0
_ALONG_SLACK_M = 1.0


class TrackDefence:
    """One defence of one track: an EKF while GNSS is trusted, a UKF while it is isolated."""

    def __init__(self, response: str, rules: Rules, fix_m: Floats, heading_rad: float) -> None:
        self.response = response
        self._rules = rules
        # Those have the odometer's scale in their covariance.
        kinds = {"consider_ukf": ConsideringEkf, "ukf5": LearningEkf, "ukf5_rollback": LearningEkf}
        self._knows_scale = response in kinds
        kind = GatedEkf if response == "gate" else kinds.get(response, GnssEkf)
        self.ekf: GnssEkf | LearningEkf | None = kind.at_first_fix(rules.noise, fix_m, heading_rad)
        self.ukf: PositionUkf | LaneUkf | None = None
        self.corrected = False
        self.went_back = False
        self._history = SightHistory(rules) if response.endswith("rollback") else None
        self._quiet_s = 0.0
        self._consistent_s = 0.0
        self._way_m = 0.0

    @property
    def isolated(self) -> bool:
        """Whether GNSS is isolated."""
        return self.ukf is not None

    @property
    def position_m(self) -> Floats:
        """The (2,) estimate."""
        return (self.ekf or self.ukf).mean[:2]  # type: ignore[union-attr]

    def step(self, sight: Sight, alarm: bool, lost: bool, residual: Residual | None, matcher: LaneMatcher) -> None:
        """Take one step."""
        step_s = self._rules.step_s
        self.went_back = False
        if self._history is not None:
            self._history.note(self.ekf or self.ukf, sight)
        if self.ekf is not None and self.response not in _TRUSTING and (alarm or lost):
            self._quiet_s = self._consistent_s = self._way_m = 0.0
            if self._history is None or lost:
                self.ukf = isolated(self.ekf, None if lost else heading_before(sight, step_s), self._rules.noise)
            else:
                self.ukf, self._way_m = self._history.go_back(matcher)
                self.went_back = True
            self.ekf = None
        if self.ekf is not None:
            self.ekf.predict(sight.speed_mps, sight.yaw_rate_rps, step_s)
            if sight.fix_m is not None:
                self.ekf.update(sight.fix_m)
        elif self.ukf is not None:
            if not self.went_back:
                self.ukf.predict(sight.speed_mps, sight.yaw_rate_rps, step_s)
                self._way_m += abs(sight.speed_mps) * step_s
            self.corrected = False
            if self.response != "dead_reckoning" and sight.lane_offset_m is not None:
                self.corrected = self.ukf.update(matcher, sight)
            self._quiet_s = 0.0 if alarm or lost else self._quiet_s + step_s
            if lost:
                self._consistent_s = 0.0
            if residual is not None:
                self._consider(self.ukf, residual)

    def _consider(self, ukf: PositionUkf | LaneUkf, residual: Residual) -> None:
        """Compare a fix with the estimate; re-join once fixes have agreed for long enough."""
        noise, settings, half = self._rules.noise, self._rules.settings, self._rules.step_s / 2.0
        ahead = np.array([cos(ukf.yaw_rad), sin(ukf.yaw_rad)])
        along = float(ahead @ (residual.fix_m - ukf.mean))
        drift = 0.0 if self._knows_scale else (noise.odometer_scale * self._way_m) ** 2
        variance = float(ahead @ ukf.covariance @ ahead) + drift + noise.gnss_white_m**2 + noise.gnss_bias_m**2
        lateral_agrees = abs(residual.z_m) <= _SIGMAS * noise.residual_m
        along_agrees = abs(along) - _ALONG_SLACK_M <= _SIGMAS * sqrt(variance)
        if lateral_agrees and along_agrees:
            self._consistent_s += max(noise.gnss_period_s, SAMPLE_S, self._rules.step_s)
        else:
            self._consistent_s = 0.0
        if self._quiet_s >= settings.hold_s - half and self._consistent_s >= settings.rejoin_s - half:
            self.ekf = ukf.trusting((drift + along**2) * np.outer(ahead, ahead))
            self.ukf = None


class TrackLocalization:
    """All defences of one track.

    Attributes:
        defences: one for each defence; none before the first fix.

    """

    def __init__(self, detectors: Sequence[int], responses: Sequence[str], rules: Rules) -> None:
        for response in responses:
            if response not in REFERENCE_RESPONSES:
                known = nearest(response, REFERENCE_RESPONSES)
                raise GpsecError(f"the reference engine has no response '{response}': {known}")
        self.defences: list[TrackDefence] = []
        self._detectors = list(detectors)
        self._responses = list(responses)
        self._rules = rules
        self._fix_age_s = inf

    def step(self, sight: Sight, alarms: Sequence[bool], residual: Residual | None, matcher: LaneMatcher) -> None:
        """Take one step; `alarms` are those of the detectors."""
        if not self.defences:
            if sight.fix_m is not None:
                self._fix_age_s = 0.0
                self.defences = [
                    TrackDefence(response, self._rules, sight.fix_m, sight.heading_rad) for response in self._responses
                ]
            return
        self._fix_age_s = 0.0 if sight.fix_m is not None else self._fix_age_s + self._rules.step_s
        lost = self._fix_age_s > self._rules.outage_s
        for defence, detector in zip(self.defences, self._detectors, strict=True):
            defence.step(sight, alarms[detector], lost, residual, matcher)
