"""`gpsec run --closed-loop`: from the command line to the folder, and on with what is missing."""

import csv
import subprocess
import sys

import pytest

SETS = (
    *("--set", "fleet.settle_s=1.0", "--set", "detection.detectors=[]", "--set", "defences=[]"),
    *("--set", "fleet.profile=carla", "--set", 'plans=[{attack="drift",share=1.0,start_after_s=[0.0,1.0]}]'),
)


def gpsec(*arguments):
    command = [sys.executable, "-m", "gpsec", "run", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def rows(path):
    return list(csv.DictReader(path.open(encoding="utf-8")))


def test_worlds_are_run_shown_and_resumed(tmp_path):
    out = tmp_path / "out"
    asked = ("slow_curve", "--closed-loop", "--duration", "8", "--seeds", "1-2", *SETS, "--out", str(out))
    ran = gpsec(*asked)
    assert ran.returncode == 0, ran.stderr
    assert "What attacks do to the traffic" in ran.stdout
    assert "slow_curve-world-01-seed-2: running" in ran.stderr
    worlds = rows(out / "worlds.csv")
    assert [(one["plan"], one["seed"]) for one in worlds] == [
        ("none", "1"),
        ("none", "2"),
        ("drift", "1"),
        ("drift", "2"),
    ]
    assert int(worlds[2]["attacked"]) > 0
    (effect,) = rows(out / "effects.csv")
    assert (effect["scenario"], effect["plan"], effect["seeds"]) == ("slow_curve", "drift", "2")
    assert "gpsec: report:" in ran.stderr
    page = (out / "report.html").read_bytes()
    made = subprocess.run([sys.executable, "-m", "gpsec", "report", str(out)], capture_output=True, check=False)
    assert (made.returncode, made.stderr) == (0, b"")
    assert (out / "report.html").read_bytes() == page
    again = gpsec(*asked, "--resume")
    assert again.returncode == 0
    assert "running" not in again.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("town", "--closed-loop", "--profile", "consumer"), "such a vehicle leaves its lane by itself"),
        (("town", "--inject-false-alarms", "some"), "expected numbers such as 0,1,5,25, found 'some'"),
        (("town", "--inject-false-alarms", "-1"), "expected 0 to 3600 a vehicle-hour"),
        (("town", "--closed-loop", "--set", "traffic.lateral_resolution_m=0"), "closed loop: expected sublanes"),
        (("town", "--closed-loop", "--engine", "reference"), "expected engine 'batched'"),
        (("town", "--closed-loop", "--set", 'closed_loop.worlds=[{plan="sealth"}]'), "did you mean 'stealth'"),
        (("town", "--closed-loop", "--set", 'closed_loop.worlds=[{defence="lstm"}]'), "unknown defence 'lstm'"),
        (("town", "--closed-loop", "--seeds", "1-900"), "expected at most 2000 worlds in all, found 3 × 900 seeds"),
        (("town", "--closed-loop", "--set", "plans=[]"), "expected a plan to attack by, found no plans"),
    ],
)
def test_what_cannot_be_is_one_sentence_and_leaves_nothing(arguments, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ran = gpsec(*arguments)
    assert ran.returncode == 2
    assert said in " ".join(ran.stderr.split())
    assert ran.stderr.count("gpsec: error:") == 1
    assert "Traceback" not in ran.stderr
    assert not (tmp_path / "results").exists() or not list((tmp_path / "results").iterdir())


def test_the_mesoscopic_model_is_refused_once_for_all_worlds(repository, tmp_path, monkeypatch):
    """It has no lateral positions; the configuration is a foreign one, beside nothing of gpsec's."""
    net = repository / "sumo_nets" / "slow_curve" / "slow_curve.net.xml"
    routes = repository / "scenarios" / "slow_curve" / "slow_curve.rou.xml"
    config = tmp_path / "meso.sumocfg"
    config.write_text(
        f'<configuration><net-file value="{net}"/><route-files value="{routes}"/>'
        '<mesosim value="true"/></configuration>'
    )
    monkeypatch.chdir(tmp_path)
    ran = gpsec(str(config), "--closed-loop", "--set", 'plans=[{attack="drift"}]')
    assert ran.returncode == 2
    (line,) = ran.stderr.splitlines()
    assert "mesosim is on: expected a microscopic simulation" in line
    assert not (tmp_path / "results").exists()
