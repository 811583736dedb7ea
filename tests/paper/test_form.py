from gpsec.paper.form import table_one_form
from gpsec.paper.tables import PaperRow


def _rows(label, figures):
    metrics = ("precision", "recall", "f1", "delay_mean_s")
    return [PaperRow(label, metric, None, value, None, None, 5) for metric, value in zip(metrics, figures, strict=True)]


def test_the_papers_figures_stand_above_ours():
    written = "as written / carla on sharp_turns / nearest / 1e-3/sample"
    rows = _rows(f"{written} / constant_bias / lstm", (0.5, 0.25, 1 / 3, 1.04))
    rows += _rows(f"{written} / constant_bias / cusum", (None, 0.0, None, None))
    heading, _, paper, *lines = table_one_form(rows)
    assert heading == "| attack | | CUSUM | isolation forest | LSTM (Eq 10) | LSTM GLR |"
    assert paper.startswith("| constant_bias | the paper | 0.82 / 0.95 / 0.88, 0.2 s | 0.93 / 0.95 / 0.94, 0.2 s |")
    (mine,) = (line for line in lines if line.startswith(f"| | {written} |") and "0.50" in line)
    assert mine == f"| | {written} | – / 0.00 / –, – |  | 0.50 / 0.25 / 0.33, 1.0 s |  |"
    assert sum("the paper" in line for line in (paper, *lines)) == 2
