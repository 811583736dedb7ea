"""Joint: what fix and camera say together, against a filter that trusts GNSS until its own alarm."""

from dataclasses import dataclass
from typing import ClassVar

from gpsec.core.kernels import always_inline
from gpsec.detection.base import Observation
from gpsec.detection.families import each_tested
from gpsec.detection.watching import WatchingDetector

# What an unmatched step adds, as twice the logarithm of a likelihood ratio: of honest steps, one in 100,000 is.
UNMATCHED = 23.0


@always_inline
def _statistic(seen: Observation, i: int) -> float:
    return float(seen.channels.joint[i] + UNMATCHED * seen.unmatched[i])


@dataclass(frozen=True)
class Joint(WatchingDetector):
    """GLR test of innovations and camera residual over four time scales: T of `gpsec.detection.monitor`.

    A fix beside no lane of the vehicle's way, or a lane that the camera sees and the map does not have, counts as well.
    """

    name: ClassVar[str] = "joint"
    kernel = each_tested(_statistic)
