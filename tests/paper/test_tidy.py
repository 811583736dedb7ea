"""Table I as CSV has its keys in columns."""

import pandas as pd
import pytest

from gpsec.paper.tables import PaperRow, keys_of, write_tidy


@pytest.mark.parametrize(
    ("label", "keys"),
    [
        (
            "dsd on slow_curve / tracked / 1e-3/sample / constant_bias / lstm_glr",
            ["dsd on slow_curve", "tracked", "1e-3/sample", "constant_bias", "lstm_glr"],
        ),
        ("generalisation / dsd / stealth / cusum", ["generalisation, dsd", "", "", "stealth", "cusum"]),
        (
            "highway / nearest / nuscenes / lane_alias / lstm",
            ["highway, nuscenes", "nearest", "", "lane_alias", "lstm"],
        ),
    ],
)
def test_a_label_is_taken_apart(label, keys):
    assert list(keys_of(label).values()) == keys


def test_every_key_has_a_column(tmp_path):
    row = PaperRow("dsd on town / oracle / 0.1/h / none / cusum", "f1", 0.5, 0.6, 0.55, 0.65, 7)
    write_tidy([row], tmp_path / "table1.csv")
    (written,) = pd.read_csv(tmp_path / "table1.csv").to_dict("records")
    assert written == {
        **{"set_up": "dsd on town", "association": "oracle", "rate": "0.1/h", "attack": "none", "detector": "cusum"},
        **{"metric": "f1", "paper": 0.5, "gpsec": 0.6, "lo": 0.55, "hi": 0.65, "n": 7},
    }
