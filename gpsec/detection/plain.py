"""Detectors in plain numpy or scikit-learn: no kernel, all vehicles of a step at once, and some ten times as slow."""

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.tables import Table, blank
from gpsec.core.threads import Threads
from gpsec.detection.alarm import AlarmSteps
from gpsec.detection.base import Detector, Observation
from gpsec.types.answers import Answers


class WindowState(NamedTuple):
    """The last residuals of each of M rows.

    Attributes:
        window: (M, W, C) normalised residuals, and channels of the monitor, the newest last.
        filled: (M,) how many of them there are.
    """

    window: Floats = blank(0.0, "samples", "columns")
    filled: Ints = blank(0)


class WindowDetector(Detector):
    """Scores windows of the last valid residuals; a subclass states `name` and `samples`, and writes `score`.

    With `channels`, windows hold what the monitor says at the residuals, too.

    A row's score must not depend on the other rows, to the last bit. A window is emptied where the last valid residual
    is longer than `gpsec.detection.alarm.GAP_S` ago, and alarms are held like those of every detector.

    Attributes:
        samples: W, length of a window.
        channels: fields of `gpsec.detection.channels.Channels` that a window has beside the residual.
    """

    heeds_alarm: ClassVar[bool] = False
    samples: ClassVar[int]
    channels: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls) -> None:
        """Note whether the monitor has to run."""
        cls.reads_monitor = bool(cls.channels)

    @abstractmethod
    def score(self, windows: Floats, profile: Ints) -> Floats:
        """Return (n,) statistics, at least 0 and finite, the higher the more anomalous.

        Args:
            windows: (n, W) residuals divided by the scale that the sensor profile promises, the newest last; where the
                detector has C - 1 `channels`, (n, W, C), the residual first.
            profile: (n,) index of the sensor profile among those that the detector was built for.
        """

    def new_state(self, capacity: int) -> Table[WindowState]:
        """Return empty windows for `capacity` rows."""
        return Table(WindowState, capacity, samples=self.samples, columns=1 + len(self.channels))

    def update(
        self,
        state: Any,
        seen: Observation,
        threshold: Floats,
        answers: Answers,
        column: int,
        threads: Threads | None = None,
    ) -> None:
        """Take the valid residuals into the windows, and score the full ones.

        Raises:
            TypeError: `score` gave another shape or type.
        """
        alarm_steps = AlarmSteps.at(seen.step_s)
        full = self._remember(state, seen, alarm_steps.gap_steps)
        rows = seen.rows[full]
        windows = state.window[rows]
        statistic = self.score(windows if self.channels else windows[..., 0], seen.profile[full])
        if statistic.shape != rows.shape or statistic.dtype != np.float64:
            found = f"{statistic.shape} of {statistic.dtype}"
            raise TypeError(f"detector '{self.name}': score must be {rows.shape} of float64, found {found}")
        answers.statistic[seen.rows, column] = 0.0
        answers.scored[seen.rows, column] = False
        answers.unscored_steps[seen.rows, column] += 1
        answers.unscored_steps[rows, column] = 0
        late = seen.rows[answers.unscored_steps[seen.rows, column] > alarm_steps.hold_steps]
        answers.alarm[late, column] = False
        answers.statistic[rows, column] = statistic
        answers.scored[rows, column] = True
        answers.alarm[rows, column] = statistic > threshold[full]

    def _remember(self, state: WindowState, seen: Observation, gap_steps: int) -> Ints:
        """Take the valid residuals; return the positions in the observation whose window is full."""
        valid = np.flatnonzero(seen.valid)
        rows = seen.rows[valid]
        gone = rows[seen.elapsed_steps[valid] > gap_steps]
        state.filled[gone] = 0
        state.window[gone] = 0.0
        state.window[rows, :-1] = state.window[rows, 1:]
        state.window[rows, -1, 0] = seen.residual_m[valid] / seen.scale_m[valid]
        for column, name in enumerate(self.channels, start=1):
            state.window[rows, -1, column] = getattr(seen.channels, name)[valid]
        state.filled[rows] = np.minimum(state.filled[rows] + 1, self.samples)
        full: Ints = valid[state.filled[rows] == self.samples].astype(np.int32)
        return full
