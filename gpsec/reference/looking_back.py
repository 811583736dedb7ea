"""Copies of a monitor's filter that are given no more fixes, and the fixes since, for one track."""

from copy import deepcopy
from dataclasses import dataclass, field

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.reference.monitor_ekf import MonitorEkf
from gpsec.reference.sight import Sight

_DECAY = 0.85
_COPIES, _EVERY_S, _LEAST_S = 4, 3.0, 2.0


@dataclass
class _Copy:
    """A filter of the past, and the innovations of fixes against it."""

    ekf: MonitorEkf
    age_s: float = 0.0
    innovations: list[Floats] = field(default_factory=list)

    def compare(self, fix_m: Floats, white: float) -> float:
        """Return the squared distance of the mean of the last fixes from this filter."""
        new = fix_m - self.ekf.expected_fix_m
        if self.innovations:
            before, _ = self._mean()
            if (before @ new - before @ before / 2.0) / white < -3.0:
                self.innovations.clear()
        self.innovations.append(new)
        mean, share = self._mean()
        return float(mean @ np.linalg.solve(self.ekf.fix_covariance(share * white), mean))

    def _mean(self) -> tuple[Floats, float]:
        """Return the weighted mean of the innovations, and how large its variance is beside that of one."""
        weights = _DECAY ** np.arange(len(self.innovations))[::-1]
        mean: Floats = weights @ np.array(self.innovations) / weights.sum()
        return mean, float(weights @ weights / weights.sum() ** 2)


class TrackLags:
    """The filters of the past of one track; see `gpsec.detection.looking_back`."""

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s
        self._copies: list[_Copy] = []
        self._since_s = _EVERY_S

    def step(self, sight: Sight, ekf: MonitorEkf, white: float, tested: bool, alarm: bool) -> float:
        """Take a step, after the monitor has; return the statistic, not scaled."""
        half, statistic = self._step_s / 2.0, 0.0
        for one in self._copies:
            one.age_s += self._step_s
            one.ekf.move(sight.speed_mps, sight.yaw_rate_rps, self._step_s)
            if tested and sight.fix_m is not None:
                found = one.compare(sight.fix_m, white)
                if one.age_s > _LEAST_S - half:
                    statistic = max(statistic, found)
        self._since_s += self._step_s
        if self._since_s > _EVERY_S - half and not alarm:
            self._copies = [*self._copies[-(_COPIES - 1) :], _Copy(deepcopy(ekf))]
            self._since_s = 0.0
        return statistic
