"""The detectors that can be chosen by name."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from gpsec.core.registry import Registry
from gpsec.detection.base import Detector, LabelledDetector
from gpsec.detection.bounds import Never, Told
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.innovation import Innovation
from gpsec.detection.isolation_forest import IsolationForest
from gpsec.detection.joint import Joint
from gpsec.detection.learned import Learned, OnStage
from gpsec.detection.logs import ResidualLog
from gpsec.detection.lstm import Lstm
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.detection.lstm_glr import LstmGlr
from gpsec.detection.separation import Separation


@dataclass(frozen=True)
class Entry:
    """How to come by a detector.

    Attributes:
        description: one line for a list.
        build: makes it for profiles, given what was learned on each; nothing where there is nothing to learn.
        learn: learn(logs, seed, progress) gives the arrays for one profile and matching.
        threshold: what it is compared with where that is not calibrated, None where it is.
        reads_monitor: it is given channels of the monitor, see `gpsec.detection.base.Detector`.
        learns_from: the detector before it in the registry whose arrays it is built of, where it has none of its own.
    """

    description: str
    build: Callable[[Sequence[Learned]], Detector | LabelledDetector]
    learn: Callable[[Sequence[ResidualLog], int, OnStage], Learned] | None = None
    threshold: float | None = None
    learns_from: str | None = None
    reads_monitor: bool = False


# Training needs scipy, scikit-learn and torch; a run does not, so they are imported by the one who trains.
def _learn_cusum(logs: Sequence[ResidualLog], seed: int, progress: OnStage) -> Learned:
    from gpsec.detection import whitening

    return whitening.learn_whitening(logs, seed, progress)


def _learn_forest(logs: Sequence[ResidualLog], seed: int, progress: OnStage) -> Learned:
    from gpsec.detection import forest_training

    return forest_training.learn_forest(logs, seed, progress)


def _learn_lstm(logs: Sequence[ResidualLog], seed: int, progress: OnStage) -> Learned:
    from gpsec.detection import lstm_training

    return lstm_training.learn_lstm(logs, seed, progress)


def _learn_lstm_glr(logs: Sequence[ResidualLog], seed: int, progress: OnStage) -> Learned:
    from gpsec.detection import lstm_training

    return lstm_training.learn_lstm_glr(logs, seed, progress)


def _take(made: Any) -> tuple[str, Entry] | None:
    """Return the entry of a class from outside gpsec, from what the class says of itself.

    Beside its name, a class may have ``learn(logs, seed, progress)`` and ``from_learned(learned)`` where it learns, and
    a ``fixed_threshold`` where its threshold is not calibrated.
    """
    if not isinstance(made, type) or not issubclass(made, Detector) or not isinstance(getattr(made, "name", None), str):
        return None
    build = getattr(made, "from_learned", None) or (lambda learned: made())
    description = (made.__doc__ or "").strip().partition("\n")[0]
    learn = getattr(made, "learn", None)
    threshold = getattr(made, "fixed_threshold", None)
    return made.name, Entry(description, build, learn, threshold, reads_monitor=made.reads_monitor)


DETECTORS: Registry[Entry] = Registry(
    "detector",
    "gpsec.detectors",
    {
        ChiSquare.name: Entry("mean squared normalised residual over a short window", lambda learned: ChiSquare()),
        Cusum.name: Entry("two-sided cumulative sums of the whitened residual", Cusum.from_learned, _learn_cusum),
        IsolationForest.name: Entry(
            "isolation forest on windows of the residual", IsolationForest.from_learned, _learn_forest
        ),
        Lstm.name: Entry(
            "mean squared error of an LSTM's prediction of the next residual: Eq 10", Lstm.from_learned, _learn_lstm
        ),
        LstmGlr.name: Entry(
            "likelihood ratio of an LSTM's errors, over several time scales", LstmGlr.from_learned, _learn_lstm_glr
        ),
        LstmCusum.name: Entry(
            "two-sided cumulative sums of the error of the LSTM's prediction",
            LstmCusum.from_learned,
            learns_from=LstmGlr.name,
        ),
        Innovation.name: Entry(
            "innovations of fixes over four time scales, against a filter that refuses spoofed ones",
            lambda learned: Innovation(),
            reads_monitor=True,
        ),
        Joint.name: Entry(
            "innovations of fixes and the camera's residual together, likewise",
            lambda learned: Joint(),
            reads_monitor=True,
        ),
        Separation.name: Entry(
            "fixes against filters that have not used them, for what a filter has absorbed",
            lambda learned: Separation(),
            reads_monitor=True,
        ),
        Told.name: Entry("is told at once when an attack begins and ends", lambda learned: Told(), threshold=0.5),
        Never.name: Entry("never raises an alarm", lambda learned: Never(), threshold=1.0),
    },
    _take,
)
