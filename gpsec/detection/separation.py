"""Separation: fixes against filters that have not used them, for what a filter has absorbed."""

from dataclasses import dataclass
from typing import ClassVar

from gpsec.core.kernels import always_inline
from gpsec.detection.base import Observation
from gpsec.detection.families import each_tested
from gpsec.detection.watching import WatchingDetector


@always_inline
def _statistic(seen: Observation, i: int) -> float:
    return float(seen.channels.separation[i])


@dataclass(frozen=True)
class Separation(WatchingDetector):
    """Solution separation from filters whose fixes are 2 to 12 s old: T of `gpsec.detection.looking_back`."""

    name: ClassVar[str] = "separation"
    looks_back: ClassVar[bool] = True
    kernel = each_tested(_statistic)
