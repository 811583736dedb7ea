"""Detectors in plain numpy or scikit-learn: no kernel, all vehicles of a step at once, and some ten times as slow."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.threads import Threads
from gpsec.detection.alarm import GAP_S, HOLD_S, AlarmState, blank_alarm, steps_in
from gpsec.detection.base import Detector, Observation, Verdict


@dataclass
class WindowState(AlarmState):
    """The last residuals of each of M rows.

    Attributes:
        window: (M, W) normalised residuals, the newest last.
        filled: (M,) how many of them there are.
    """

    window: Floats
    filled: Ints

    @classmethod
    def of(cls, capacity: int, samples: int) -> Self:
        """Return `capacity` rows that have seen nothing, with room for `samples` residuals."""
        window, filled = np.zeros((capacity, samples)), np.zeros(capacity, np.int32)
        return cls(**blank_alarm(capacity), window=window, filled=filled)


class WindowDetector(Detector):
    """Scores windows of the last valid residuals; a subclass states `name` and `samples`, and writes `score`.

    A row's score must not depend on the other rows, to the last bit. A window is emptied where the last valid residual
    is longer than `gpsec.detection.alarm.GAP_S` ago, and alarms are held like those of every detector.

    Attributes:
        samples: W, length of a window.
    """

    samples: ClassVar[int]

    @abstractmethod
    def score(self, windows: Floats, profile: Ints) -> Floats:
        """Return (n,) statistics, at least 0 and finite, the higher the more anomalous.

        Args:
            windows: (n, W) residuals divided by the scale that the sensor profile promises, the newest last.
            profile: (n,) index of the sensor profile among those that the detector was built for.
        """

    def new_state(self, capacity: int) -> WindowState:
        """Return empty windows for `capacity` rows."""
        return WindowState.of(capacity, self.samples)

    def update(
        self,
        state: AlarmState,
        observation: Observation,
        threshold: Floats,
        verdict: Verdict,
        threads: Threads | None = None,
    ) -> None:
        """Take the valid residuals into the windows, and score the full ones.

        Raises:
            TypeError: the state is another detector's, or `score` gave another shape or type.
        """
        if not isinstance(state, WindowState):
            raise TypeError(f"detector '{self.name}': expected its own state, found {type(state).__name__}")
        full = self._remember(state, observation)
        rows = observation.rows[full]
        value = self.score(state.window[rows], observation.profile[full])
        if value.shape != rows.shape or value.dtype != np.float64:
            found = f"{value.shape} of {value.dtype}"
            raise TypeError(f"detector '{self.name}': score must be {rows.shape} of float64, found {found}")
        hold_steps = steps_in(HOLD_S, observation.step_s)
        state.since_scored[observation.rows] += 1
        state.since_scored[rows] = 0
        late = observation.rows[state.since_scored[observation.rows] > hold_steps]
        state.alarm[late] = False
        state.alarm[rows] = value > threshold[full]
        at = observation.rows, verdict.column
        verdict.statistic[at] = 0.0
        verdict.scored[at] = False
        verdict.statistic[rows, verdict.column] = value
        verdict.scored[rows, verdict.column] = True
        verdict.alarm[at] = state.alarm[observation.rows]

    def _remember(self, state: WindowState, seen: Observation) -> Ints:
        """Take the valid residuals; return the positions in the observation whose window is full."""
        state.since_valid[seen.rows[~seen.valid]] += 1
        valid = np.flatnonzero(seen.valid)
        rows = seen.rows[valid]
        gone = rows[state.since_valid[rows] + 1 > steps_in(GAP_S, seen.step_s)]
        state.filled[gone] = 0
        state.window[gone] = 0.0
        state.since_valid[rows] = 0
        state.window[rows, :-1] = state.window[rows, 1:]
        state.window[rows, -1] = seen.residual_m[valid] / seen.scale_m[valid]
        state.filled[rows] = np.minimum(state.filled[rows] + 1, self.samples)
        full: Ints = valid[state.filled[rows] == self.samples].astype(np.int32)
        return full
