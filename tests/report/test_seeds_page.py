"""The page of a run with several seeds: what is taken together is shown, and what is not is not denied."""

import json
import re
import shutil

import pytest

from gpsec.outcomes.merging import merge
from gpsec.report.make import write_report
from gpsec.report.page import unpacked
from gpsec.running.results import load

from .conftest import write_run


def _of_seed_2(found):
    return found[0].replace("1", "2")


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    here = tmp_path_factory.mktemp("seeds")
    first = write_run(here / "lane-seed-1", "lane-seed-1", log=False)
    (stated,) = json.loads((first / "manifest.json").read_text("utf-8"))["scenarios"]
    (first / "manifest.json").write_text(json.dumps(stated))
    second = shutil.copytree(first, here / "lane-seed-2")
    for path in (second / "manifest.json", *second.glob("*.csv")):
        path.write_text(re.sub('seed-1(,1,)?|(?<=seed": )1', _of_seed_2, path.read_text("utf-8")))
    folders = [first, second]
    out = here / "out"
    out.mkdir()
    merge(folders, out)
    return write_report(load(out)).read_text("utf-8")


@pytest.fixture(scope="module")
def data(text):
    (packed,) = re.findall(r'id="data"[^>]*>([^<]+)<', text)
    return json.loads(unpacked(packed.strip()))


def shown(data, key, group, attack="bias"):
    wanted = {"group": group, "attack": attack}
    return [one for one in data["figures"][key]["series"] if wanted.items() <= one["where"].items()]


def test_figures_of_vehicles_have_those_of_all_seeds(data):
    assert (data["pooled"], data["groups"][0]) == (["lane · dsd"], "lane · dsd")
    assert [one["text"][0] for one in shown(data, "outcomes", "lane · dsd")][:2] == ["4 of 4", "4 of 4"]
    assert [one["text"][0] for one in shown(data, "outcomes", "lane-seed-1 · dsd")][:2] == ["2 of 2", "2 of 2"]
    together, alone = (shown(data, "delay", name)[0] for name in ("lane · dsd", "lane-seed-1 · dsd"))
    assert (together["y"][-1], alone["y"][-1]) == (1.0, 1.0)
    assert together["x"] == [0.0, *alone["x"][1:] * 2]  # two vehicles a seed, each seen after as long
    assert len(shown(data, "cost", "lane · dsd")) == 1
    assert shown(data, "roc", "lane · dsd") == []  # of each seed by itself


def test_an_attack_that_was_seen_is_not_said_to_be_missed(text):
    assert text.count("seen after 0.5") == 3  # under the bias, of both seeds and together
    assert "<title>gpsec: lane</title>" in text
