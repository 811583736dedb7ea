"""Joint: what fix and camera say together, against a filter that trusts GNSS until its own alarm."""

from dataclasses import dataclass
from typing import ClassVar

from gpsec.core.kernels import always_inline
from gpsec.detection.base import Observation
from gpsec.detection.families import each_tested
from gpsec.detection.watching import WatchingDetector


@always_inline
def _statistic(seen: Observation, i: int) -> float:
    return float(seen.channels.joint[i])


@dataclass(frozen=True)
class Joint(WatchingDetector):
    """GLR test of innovations and camera residual over four time scales: T of `gpsec.detection.monitor`."""

    name: ClassVar[str] = "joint"
    kernel = each_tested(_statistic)
