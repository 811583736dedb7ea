"""The recorded past of one defence, and the restart from it."""

from copy import deepcopy
from dataclasses import dataclass
from math import ceil

from gpsec.filters.noise import FilterNoise
from gpsec.localization.rejoin import SwitchSettings
from gpsec.reference.considering import ConsideringEkf, ConsideringUkf
from gpsec.reference.filters import GnssEkf, PositionUkf, wrapped
from gpsec.reference.learning import LaneUkf, LearningEkf
from gpsec.reference.matching import LaneMatcher
from gpsec.reference.sight import Sight

_YAW_SIGMAS = 4.0
_LOST_PERIODS = 2.5


@dataclass(frozen=True)
class Rules:
    """The settings of a vehicle's switch.

    Attributes:
        noise: figures of its sensors.
        settings: when GNSS is given up and taken back.
        step_s: length of a step.

    """

    noise: FilterNoise[float]
    settings: SwitchSettings
    step_s: float

    @property
    def outage_s(self) -> float:
        """Without a fix for longer than this, GNSS is lost."""
        return max(self.settings.outage_s, _LOST_PERIODS * self.noise.gnss_period_s)

    @property
    def reach(self) -> int:
        """Steps that a response goes back at least."""
        return ceil(self.settings.rollback_s / self.step_s - 1e-6)

    @property
    def interval(self) -> int:
        """Steps from one kept filter to the next: five of them reach back far enough from anywhere."""
        return max(ceil(self.reach / 4), 1)


def heading_before(sight: Sight, step_s: float) -> float:
    """Return the heading sensor's yaw before a step."""
    return sight.heading_rad - sight.yaw_rate_rps * step_s


def isolated(ekf: GnssEkf | LearningEkf, heading_rad: float | None, noise: FilterNoise[float]) -> PositionUkf | LaneUkf:
    """Return a filter that goes on without GNSS.

    Where spoofed fixes have turned the filter, the heading sensor's yaw is better; None where fixes were only lost.
    """
    ukf: PositionUkf | LaneUkf
    if isinstance(ekf, ConsideringEkf):
        ukf = ConsideringUkf.isolated(ekf)
    else:
        ukf = LaneUkf.isolated(ekf) if isinstance(ekf, LearningEkf) else PositionUkf.isolated(ekf)
    if heading_rad is not None and abs(wrapped(ukf.yaw_rad - heading_rad)) > _YAW_SIGMAS * noise.heading_rad:
        ukf.take_yaw(heading_rad)
    return ukf


class SightHistory:
    """Sensor data of all steps since the first fix, and copies of the filter from some of them."""

    def __init__(self, rules: Rules) -> None:
        self._rules = rules
        self._sights: list[Sight] = []
        self._kept: dict[int, GnssEkf | LearningEkf | PositionUkf | LaneUkf] = {}

    def note(self, before: GnssEkf | LearningEkf | PositionUkf | LaneUkf | None, sight: Sight) -> None:
        """Record the sensor data of a step, and sometimes the filter before it."""
        if before is not None and len(self._sights) % self._rules.interval == 0:
            self._kept[len(self._sights)] = deepcopy(before)
        self._sights.append(sight)

    def go_back(self, matcher: LaneMatcher) -> tuple[PositionUkf | LaneUkf, float]:
        """Return the filter from before the attack, propagated to now without GNSS, and the distance travelled.

        The camera of the last step is not used yet.
        """
        rules, last = self._rules, len(self._sights) - 1
        first = max(last - rules.reach, 0) // rules.interval * rules.interval
        before = deepcopy(self._kept[first])
        if isinstance(before, GnssEkf | LearningEkf):
            ukf = isolated(before, heading_before(self._sights[first], rules.step_s), rules.noise)
        else:
            ukf = before
        way_m = 0.0
        for step in range(first, last + 1):
            sight = self._sights[step]
            if step > first and step % rules.interval == 0:
                self._kept[step] = deepcopy(ukf)
            ukf.predict(sight.speed_mps, sight.yaw_rate_rps, rules.step_s)
            way_m += abs(sight.speed_mps) * rules.step_s
            if step < last and sight.lane_offset_m is not None:
                ukf.update(matcher, sight)
        return ukf, way_m
