"""The detectors of a run, with what they need of its profiles."""

from dataclasses import dataclass

from gpsec.core.arrays import Floats
from gpsec.detection.base import Detector, LabelledDetector
from gpsec.detection.pairing import Sampling


@dataclass(frozen=True)
class Watchers:
    """The detectors of a run.

    Attributes:
        names: of the K detectors.
        detectors: themselves.
        thresholds: (profiles, K).
        scale_m: (profiles,) standard deviation of the residual that each profile promises.
        sampling: how old samples may be of which a residual is formed.

    """

    names: tuple[str, ...]
    detectors: tuple[Detector | LabelledDetector, ...]
    thresholds: Floats
    scale_m: Floats
    sampling: Sampling
