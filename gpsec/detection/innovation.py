"""Innovation: what fixes alone say against a filter that trusts GNSS until the monitor's alarm."""

from dataclasses import dataclass
from typing import ClassVar

from gpsec.core.kernels import always_inline
from gpsec.detection.base import Observation
from gpsec.detection.families import each_tested
from gpsec.detection.watching import WatchingDetector


@always_inline
def _statistic(seen: Observation, i: int) -> float:
    return float(seen.channels.innovation[i])


@dataclass(frozen=True)
class Innovation(WatchingDetector):
    """GLR test of the innovations over four time scales: `joint` without the camera's channel."""

    name: ClassVar[str] = "innovation"
    kernel = each_tested(_statistic)
