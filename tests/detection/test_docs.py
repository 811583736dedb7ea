from pathlib import Path

from gpsec.detection import forest_training
from gpsec.detection.alarm import GAP_S, HOLD_S
from gpsec.detection.calibration import MAX_ROUNDS, MIN_EVENTS, RATES
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.isolation_forest import WINDOW
from gpsec.detection.lstm import CLIP, Lstm
from gpsec.detection.lstm_cell import HIDDEN
from gpsec.detection.registry import DETECTORS

DOCS = Path(__file__).parents[2] / "docs"


def test_parameters_in_the_docs_are_those_of_the_code():
    text = (DOCS / "detection.md").read_text()
    cusum, lstm = Cusum((1.0,), (1.0,), (1.0,)), Lstm(())
    stated = [
        f"n = {ChiSquare().window} |",
        f"k = {cusum.slack:g}, clip {cusum.clip:g}, reach {cusum.reach:g}, plausible {cusum.plausible:g},"
        f" margin {cusum.margin:g}",
        f"w = {WINDOW}, {forest_training.TREES} trees, ψ = {forest_training.SAMPLES}",
        f"n = {lstm.window}, {HIDDEN} hidden units, clip {CLIP:g}, distrust {lstm.distrust}",
        f"at most {HOLD_S:g} s",
        f"more than {GAP_S:g} s",
        *(f"`{rate}`" for rate in RATES),
        *(f"| `{name}` |" for name in DETECTORS),
    ]
    assert [phrase for phrase in stated if phrase not in text] == []
    assert (MIN_EVENTS, MAX_ROUNDS) == (10.0, 8)  # "fewer than ten events", "eight runs"
