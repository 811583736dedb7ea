"""What every detector of one track does: it scores residuals, raises, holds and ends its alarm."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from gpsec.detection.alarm import GAP_S
from gpsec.reference.sight import Sight
from gpsec.types.points import HOLD_S


@dataclass(frozen=True)
class TrackVerdict:
    """The result of a detector in one step; the statistic is 0 where nothing was scored."""

    statistic: float
    scored: bool
    alarm: bool


@dataclass(frozen=True)
class Scale:
    """The settings of a detector for one sensor profile.

    Attributes:
        profile: index of the profile.
        scale_m: standard deviation of the residual that the profile promises.
        threshold: over which a statistic is an alarm.
        step_s: length of a step.

    """

    profile: int
    scale_m: float
    threshold: float
    step_s: float


class TrackDetector(ABC):
    """One detector of one track: when it scores, and when its alarm begins, is held and ends."""

    def __init__(self, scale: Scale) -> None:
        self.scale = scale
        self.alarm = False
        self._valid_before_s = 0.0
        self._scored_before_s = 0.0
        # Sums of steps do not meet round figures exactly.
        self._late_s = 1e-6 * scale.step_s

    def step(self, sight: Sight, residual_m: float | None, attacked: bool) -> TrackVerdict:
        """Take one step; only `told` reads `attacked`."""
        self._valid_before_s += self.scale.step_s
        self._scored_before_s += self.scale.step_s
        statistic = None
        z = None if residual_m is None else residual_m / self.scale.scale_m
        if z is not None:
            if self._valid_before_s > GAP_S + self._late_s:
                self.forget()
            statistic = self.score(z, sight, self._valid_before_s)
            self._valid_before_s = 0.0
        verdict = self.decide(statistic)
        if z is not None:
            self.learn(z)
        return verdict

    def decide(self, statistic: float | None) -> TrackVerdict:
        """Raise, hold or end the alarm."""
        if statistic is not None:
            self.alarm = statistic > self.scale.threshold
            self._scored_before_s = 0.0
        elif self._scored_before_s > HOLD_S + self._late_s:
            self.alarm = False
        return TrackVerdict(statistic or 0.0, statistic is not None, self.alarm)

    @abstractmethod
    def forget(self) -> None:
        """Begin anew: there was no valid residual for too long."""

    @abstractmethod
    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the statistic, None in warm-up, for a normalised residual that comes `elapsed_s` after the last."""

    def learn(self, z: float) -> None:  # noqa: B027 - most have nothing to do
        """Take in the normalised residual, once it is decided whether there is an alarm."""


class TrackWatching(TrackDetector):
    """A detector whose statistic is the monitor's."""

    def __init__(self, statistic: str, scale: Scale) -> None:
        super().__init__(scale)
        self._statistic = statistic

    def step(self, sight: Sight, residual_m: float | None, attacked: bool) -> TrackVerdict:
        """Take one step."""
        self._scored_before_s += self.scale.step_s
        return self.decide(float(getattr(sight.told, self._statistic)) if sight.told.tested else None)

    def forget(self) -> None:
        """Do nothing: all is remembered by the monitor."""

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return nothing: the residual is a matter of the monitor."""
        return None
