"""The code in docs/analysis.md runs, and answers what it says."""

import json
import re
import runpy
import shutil
from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest

from .conftest import EVIL, write_run

GUIDE = (Path(__file__).parents[2] / "docs" / "analysis.md").read_text("utf-8")


@pytest.fixture(scope="module")
def names(run_folder, tmp_path_factory):
    """What the blocks leave behind, run one after the other.

    They run on the run made by hand, with an LSTM that is CUSUM, but 0.2 s later.
    """
    blocks = re.findall(r"```python\n(.*?)```", GUIDE, re.DOTALL)
    assert len(blocks) == 12
    folder = shutil.copytree(run_folder, tmp_path_factory.mktemp("analysis") / "run")
    for table in ("events", "curves", "safety"):
        frame = pd.read_csv(folder / f"{table}.csv")
        column = "detector" if "detector" in frame else "defence"
        more = frame[frame[column].str.startswith("cusum")].replace({"cusum": "lstm_glr", "cusum+ukf": "lstm_glr+ukf"})
        if table == "events":
            more["detection_delay_s"] += 0.2
        pd.concat([frame, more]).to_csv(folder / f"{table}.csv", index=False)
    script = folder / "analysis.py"
    script.write_text("\n".join(blocks).replace("results/fleet-eval", str(folder)), encoding="utf-8")
    shutil.copy(folder / "steps.parquet", folder / "traces.parquet")  # the same columns
    mpl.use("Agg")
    return runpy.run_path(str(script))


def test_every_undefended_vehicle_left_its_lane(names):
    assert names["worst"]["out_of_lane_share"].tolist() == [1.0, 1.0]
    assert names["worst"]["n_vehicles"].tolist() == [2, 2]


def test_detectors_are_compared_at_the_same_rate_and_on_the_same_attacks(names):
    assert (names["recall"]["lstm_glr"] == names["recall"]["cusum"]).all()
    assert names["later_s"].tolist() == pytest.approx([0.2, 0.2])
    assert (names["low"], names["high"]) == (pytest.approx(0.2), pytest.approx(0.2))
    curves = names["run"].curves.query("profile == 'dsd' and attack == 'bias' and detector == 'cusum'")
    points = curves.sort_values("false_positive_rate")[["false_positive_rate", "recall"]].to_numpy()
    below, above = next((a, b) for a, b in pairwise(points) if a[0] <= 1e-3 < b[0])
    assert below[1] >= 35 / 40  # at its threshold it is late by 5 of 40 steps
    between = below[1] + (above[1] - below[1]) * (1e-3 - below[0]) / (above[0] - below[0])
    assert names["recall"].loc[("lane", "dsd", "bias"), "cusum"] == pytest.approx(between)


def test_attacks_are_missed_where_only_the_bias_is_seen(names):
    missed = names["missed"]
    # Nothing can be scored under jamming, so that nothing of it is missed.
    assert missed.groupby("attack", observed=True)["missed"].mean().to_dict() == {"bias": 0.0, EVIL: 1.0}
    assert set(missed["east_m"]) == {0.0}
    # Two vehicles under each of the two, all of them in one square.
    squares = names["squares"]
    assert (squares["vehicles"].tolist(), squares["missed"].tolist()) == ([4], [0.5])


def test_mitigation_keeps_everybody_in_the_lane(names):
    bought = names["bought"]
    assert bought.loc[("bias", "left")].tolist() == [1.0, 1.0, 1.0]
    assert bought.loc[("bias", "max_cross_track_m"), "mean"] == pytest.approx(2.0 - 0.05)


def test_vehicles_that_an_interval_takes(names):
    # Two of two: p = 3/4, and 1.96² · 3/16 / 0.02² = 1800.75.
    assert set(names["vehicles_needed"]) == {1801.0}


def test_runs_of_other_seeds(names, run_folder, tmp_path):
    other = write_run(tmp_path / "other", error_m=1.0, log=False)
    mean, half = names["over_seeds"]([run_folder, other], "bias")
    assert mean == 0.5  # all of them, and none
    assert half == pytest.approx(12.706 * 0.5, rel=1e-4)  # t for one degree of freedom, s / √2 = 0.5


def test_the_notebook_has_the_same_code(repository):
    made = runpy.run_path(str(repository / "docs" / "notebook.py"))["notebook"](GUIDE)
    assert (repository / "docs" / "analysis.ipynb").read_text("utf-8") == made
    cells = json.loads(made)["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert code == [block.strip() for block in re.findall(r"```python\n(.*?)```", GUIDE, re.DOTALL)]


def test_streets_have_their_exposure(names):
    """Undefended vehicles leave the only edge at once: six events of 5.5 s from the beginning of the attack on."""
    (row,) = names["by_street"].reset_index().to_dict("records")
    assert (row["edge"], row["departures"]) == ("e", 6)
    assert row["vehicle_seconds"] == pytest.approx(6 * 6.0)
    assert row["departures_per_hour"] == pytest.approx(6 / (36.0 / 3600))


def test_errors_are_drawn_for_every_defence(names):
    assert {line.get_label() for line in names["axes"].get_lines()} == set(names["growth"].columns)


def widths(axes):
    """Lengths of horizontal bars from the top on."""
    return [bar.get_width() for bar in axes.patches][::-1]


def test_the_other_questions_are_drawn_too(names):
    assert widths(names["worst_axes"]) == names["worst"]["out_of_lane_share"].tolist()
    assert [bar.get_width() for bar in names["recall_axes"].patches] == [0.0] * names["ahead"].size
    later, sooner = names["delay_axes"].get_lines()
    delays = later.get_xdata() - sooner.get_xdata()
    assert np.nanmax(delays) == pytest.approx(0.2) == np.nanmin(delays)
    assert np.isnan(delays).sum() == 4  # of six attacks two are seen
    (points,) = names["map_axes"].collections
    assert (points.get_offsets().tolist(), points.get_array().tolist()) == ([[50.0, 50.0]], [0.5])
    assert 1.0 in widths(names["bought_axes"])
    assert widths(names["street_axes"]) == names["streets"]["departures_per_hour"].tolist()


def test_sql_counts_and_measures_the_same(names):
    left = names["left"].set_index(["attack", "defence"])
    assert left.loc[("bias", "never+none"), ["attacked", "left_share"]].tolist() == [2, 1.0]
    off = names["off"][names["off"]["plan"] == "bias"]
    assert off["steps"].tolist() == [40, 40]
    assert off["off_m"].tolist() == pytest.approx([2.0, 2.0], abs=0.2)  # 2 m to the left, and 0.1 m ahead
    # Garwood's bounds of a count of six.
    assert (names["fewest"].tolist(), names["most"].tolist()) == (
        pytest.approx([2.2019], abs=1e-3),
        pytest.approx([13.0595], abs=1e-3),
    )


def test_the_best_defences_are_blue(names):
    bars = names["ranking_axes"].patches[::-1]
    shares = {one.defence: one.share for one in names["ranking"].standings.values()}
    assert [bar.get_width() for bar in bars] == sorted(shares.values())
    blue = {defence for bar, defence in zip(bars, names["shares"].index, strict=True) if bar.get_facecolor()[2] > 0.5}
    assert blue == set(names["ranking"].best)
