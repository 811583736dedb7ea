from pathlib import Path

from gpsec.detection import forest_training
from gpsec.detection.alarm import GAP_S, HOLD_S
from gpsec.detection.calibration import MAX_ROUNDS, MIN_EVENTS, RATES
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.forecast import CLIP, DELAY
from gpsec.detection.isolation_forest import WINDOW
from gpsec.detection.lstm import DECAYS, Lstm
from gpsec.detection.lstm_cell import HIDDEN
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.detection.registry import DETECTORS

DOCS = Path(__file__).parents[2] / "docs"


def test_parameters_in_the_docs_are_those_of_the_code():
    text = (DOCS / "detection.md").read_text()
    cusum, lstm, sums = Cusum((1.0,), (1.0,), (1.0,)), Lstm(()), LstmCusum(())
    stated = [
        f"n = {ChiSquare().window} |",
        f"k = {cusum.slack:g}, clip {cusum.clip:g}, reach {cusum.reach:g}, plausible {cusum.plausible:g},"
        f" margin {cusum.margin:g}",
        f"w = {WINDOW}, {forest_training.TREES} trees, ψ = {forest_training.SAMPLES}",
        f"λ = {', '.join(f'{decay:g}' for decay in DECAYS)}, {HIDDEN} hidden units, clip {CLIP:g}, delay {DELAY},"
        f" distrust {lstm.distrust}, plausible {lstm.plausible:g}, enough {lstm.enough:g}",
        f"slack = {sums.slack:g}, reach {sums.reach:g}, clip {sums.clip:g}, margin {sums.margin:g}",
        f"at most {HOLD_S:g} s",
        f"more than {GAP_S:g} s",
        *(f"`{rate}`" for rate in RATES),
        *(f"| `{name}` |" for name in DETECTORS),
    ]
    assert [phrase for phrase in stated if phrase not in text] == []
    assert (MIN_EVENTS, MAX_ROUNDS) == (10.0, 8)  # "fewer than ten events", "eight runs"
