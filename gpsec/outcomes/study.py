"""The names that indices stand for in the tables of one run."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.types.constants import ASSOCIATIONS
from gpsec.types.tracks import SAMPLE_S


@dataclass(frozen=True)
class Study:
    """What was compared.

    Attributes:
        plans: names of the attack plans; the first is no attack ("none").
        detectors: names of the K operating points: a detector, with its false-alarm rate where that is another one
            than the headline's.
        rates: of the K operating points, empty where a threshold is not calibrated.
        origins: of their thresholds: `counted`, `model` (of extreme values) or `fixed`.
        defences: (operating point, response) of the D defences.
        profiles: names of the sensor profiles.
        thresholds: (profiles, K) of the detectors.
        step_s: length of a step.
        association: how vehicles know their lane.

    """

    plans: tuple[str, ...]
    detectors: tuple[str, ...]
    rates: tuple[str, ...]
    origins: tuple[str, ...]
    defences: tuple[tuple[str, str], ...]
    profiles: tuple[str, ...]
    thresholds: Floats
    step_s: float
    association: str = ASSOCIATIONS[0]

    @property
    def sample_s(self) -> float:
        """Time that a scored sample stands for."""
        return max(SAMPLE_S, self.step_s)

    @cached_property
    def defence_names(self) -> tuple[str, ...]:
        """Names of the defences, detector+response."""
        return tuple(f"{detector}+{response}" for detector, response in self.defences)

    @cached_property
    def detector_of(self) -> Ints:
        """(D,) index of the detector that a defence listens to."""
        return np.array([self.detectors.index(detector) for detector, _ in self.defences], np.int32)
