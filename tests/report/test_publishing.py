"""What goes into a paper: tables that LaTeX sets, figures with embedded fonts, captions with the numbers."""

import re
import shutil
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from gpsec.cli import main
from gpsec.core.errors import GpsecError
from gpsec.report.gathering import taken_together
from gpsec.report.matched_table import mean_bounds, recall_at
from gpsec.report.press import LineLooks
from gpsec.report.published_figures import FIGURES_FOR_PAPERS
from gpsec.report.published_tables import TABLES_FOR_PAPERS, make_tables
from gpsec.report.typesetting import TypesetTable, as_latex, as_markdown, escaped
from gpsec.running.results import load

from .conftest import write_run

TABLE = TypesetTable(
    "some-name", "Of 50 % & more.", ["attack", "n_a", "x"], [["a_b", "c|d", "1"], None, ["e", "f", "2"]]
)


def test_latex_sets_every_name_as_it_is():
    assert escaped("lstm@1e-3/sample_x {50 %} #1 & ~^\\ – γ") == (
        r"lstm@1e-3/sample\_x \{50 \%\} \#1 \& \textasciitilde{}\textasciicircum{}\textbackslash{} -- $\gamma$"
    )
    text = as_latex(TABLE)
    assert r"\caption{Of 50 \% \& more.}" in text
    assert r"\begin{tabular}{llr}" in text
    assert text.count(r"\midrule") == 2
    assert r"a\_b & c|d & 1 \\" in text


def test_markdown_has_a_caption_and_as_many_cells_everywhere():
    lines = as_markdown(TABLE).splitlines()
    assert lines[0] == "Of 50 % & more."
    assert {len(re.split(r"(?<!\\)\|", line)) for line in lines[2:]} == {5}


def test_names_are_drawn_apart():
    names = [f"defence{number}" for number in range(14)]
    looks = LineLooks([*names, "plain"], "plain")
    drawn = [tuple(sorted(looks.of(name).items())) for name in [*names, "plain"]]
    assert len(set(drawn)) == 15


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("published") / "run")


@pytest.mark.parametrize("name", sorted({*TABLES_FOR_PAPERS} - {"table1", "matched"}))
def test_every_table_says_vehicles_seeds_and_intervals(folder, name):
    for table in make_tables(name, taken_together([load(folder)])):
        assert {len(row) for row in table.rows if row is not None} == {len(table.headings)}
        assert re.search(r"n (=|vehicles)", table.caption)
        assert "seed 1; 95% intervals, bootstrap of vehicles; gpsec 0.1.0" in table.caption


def test_table_one_has_the_papers_figures_and_ours_side_by_side(folder):
    (table,) = make_tables("table1", taken_together([load(folder)]))
    (row,) = (row for row in table.rows if row is not None)  # the run has one attack and one detector of the paper
    assert row[:6] == ["constant_bias", "cusum", "0.82", "0.95", "0.88", "0.20"]
    assert row[6:8] == ["1.00", "0.88"]  # 35 of 40 steps under attack are seen, none before


def test_two_seeds_are_pooled_and_named(folder, tmp_path):
    other = shutil.copytree(folder, tmp_path / "other")
    for path in (other / "manifest.json", *other.glob("*.csv")):
        path.write_text(path.read_text("utf-8").replace('"seed": 1', '"seed": 2').replace("lane,1,", "lane,2,"))
    found = taken_together([load(folder), load(other)])
    assert found.seeds == {"lane": (1, 2)}
    safety = found.tables["safety"]
    pooled = safety[(safety["scenario"] == "lane") & (safety["attack"] == "bias")]
    assert set(pooled["n_vehicles"]) == {4}
    (table,) = make_tables("defences", found)
    assert "n = 8 vehicles" in table.caption
    assert "2 seeds (1, 2); 95% intervals, bootstrap of runs, then of vehicles" in table.caption
    with pytest.raises(GpsecError, match="scenario 'lane' with seed 1 is in two of the runs"):
        taken_together([load(folder), load(folder)])


@pytest.mark.parametrize("name", FIGURES_FOR_PAPERS)
@pytest.mark.parametrize("kind", ["pdf", "svg"])
def test_figures_are_vectors_with_their_fonts(folder, tmp_path, capsys, name, kind):
    path = tmp_path / f"one.{kind}"
    assert main(["figure", str(folder), name, f"--{kind}", "--out", str(path)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == str(path)
    assert "n = " in said[1]
    data = path.read_bytes()
    if kind == "pdf":
        assert b"/Subtype /Image" not in data
        assert b"/FontFile2" in data  # TrueType, embedded
        assert b"/Type3" not in data
    else:
        root = ElementTree.fromstring(data)
        assert not root.findall(".//{http://www.w3.org/2000/svg}text")  # letters are outlines
        assert not root.findall(".//{http://www.w3.org/2000/svg}image")
    again = tmp_path / f"again.{kind}"
    assert main(["figure", str(folder), name, f"--{kind}", "--out", str(again)]) == 0
    assert again.read_bytes() == data


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["table", "RUN", "--name", "table2"], "--name: unknown table 'table2': did you mean 'table1'?"),
        (["table", "RUN", "--latex", "--markdown"], "--latex, --markdown: expected one of them"),
        (["figure", "RUN", "roq"], "NAME: unknown figure 'roq': did you mean 'roc'?"),
        (["figure", "RUN"], "expected the folder of a run and the name of a figure"),
        (["figure", "RUN", "roc", "--attack", "bais"], "--attack: 'bais' is in none of the runs: did you mean 'bias'?"),
        (["figure", "RUN", "roc", "--out", "roc.png"], "--out roc.png: expected the ending .pdf or .svg"),
    ],
)
def test_what_cannot_be_meant_is_refused(folder, capsys, arguments, said):
    assert main([str(folder) if word == "RUN" else word for word in arguments]) == 2
    assert said in capsys.readouterr().err


POINTS = pd.DataFrame({"false_positive_rate": [0.0, 5e-4, 2e-3, 1.0], "recall": [0.2, 0.5, 0.9, 1.0]})


def test_detectors_are_compared_where_they_have_the_same_false_positives():
    assert [recall_at(POINTS, rate) for rate in (1e-2, 1e-3, 1e-4)] == [0.9, 0.5, 0.2]
    low, high = mean_bounds([0.4, 0.6], 0.95)  # 12.706 · 0.1 on either side, but no less than none and no more than all
    assert (low, high) == (0.0, 1.0)
    assert mean_bounds([0.5, 0.5, 0.53], 0.95) == pytest.approx((0.51 - 0.04303, 0.51 + 0.04303), abs=1e-4)
    assert np.isnan(mean_bounds([0.5], 0.95)).all()


def test_the_matched_table_has_every_seed(folder):
    found = taken_together([load(folder)])
    names = {"profile": "dsd", "attack": "bias", "detector": "cusum"}
    first, second = (POINTS.assign(scenario=f"lane-seed-{seed}", **names) for seed in (1, 2))
    second.loc[0, "recall"] = 0.4
    other_point = first.assign(detector="cusum@1e-3/sample")  # the same curve again
    vehicles = found.tables["vehicles"].assign(scored_seconds=0.0)
    vehicles.loc[(vehicles["attack"] == "none").idxmax(), "scored_seconds"] = (
        5000.0  # 50,000 samples, 5 at the last rate
    )
    tables = {**found.tables, "curves": pd.concat([first, second, other_point]), "vehicles": vehicles}
    gathered = replace(found, tables=tables, seeds={"lane": (1, 2)})
    (table,) = make_tables("matched", gathered)
    (row,) = table.rows
    assert row == ["bias", "cusum", "0.90 (0.90 – 0.90)", "0.50 (0.50 – 0.50)", "0.30 (0.00 – 1.00)"]
    assert "over 2 seeds (1, 2); gpsec 0.1.0" in table.caption
    vehicles["scored_seconds"] *= 0.99
    ((*_, last),) = make_tables("matched", gathered)[0].rows
    assert last == "–"
