"""What is wrong in a gpsec.toml is one sentence that names the key, before anything runs."""

from pathlib import Path

import pytest

from gpsec import cli
from gpsec.running import batch

from .runs import make, never_run, sentence

BAD_TOML = {
    "unknown key": ("sede = 1", ["unknown key 'sede'", "did you mean 'seed'?"]),
    "unknown section": ("[fleets]\nx = 1", ["unknown key 'fleets'", "did you mean 'fleet'?"]),
    "unknown key in fleet": ("[fleet]\nprofil = 'dsd'", ["unknown key 'profil' in fleet", "did you mean 'profile'?"]),
    "unknown key in traffic": ("[traffic]\nstep = 0.1", ["unknown key 'step' in traffic", "'step_s'"]),
    "unknown key in detection": ("[detection]\ndetector = []", ["unknown key 'detector' in detection"]),
    "unknown key in localization": ("[localization]\nholds_s = 1", ["unknown key 'holds_s'", "'hold_s'"]),
    "unknown key in outcomes": ("[outcomes]\nbootstraps = 1", ["unknown key 'bootstraps'", "'bootstrap'"]),
    "unknown key in a defence": (
        "[[defences]]\ndetector = 'lstm_glr'\nresponse = 'ukf'\nrespons = 'ukf'",
        ["unknown key 'respons' in defences.0", "did you mean 'response'?"],
    ),
    "unknown key in a plan": ("[[plans]]\nattack = 'drift'\nrate = 1.0", ["plans.0", "'rate'", "'rate_mps'"]),
    "text for a number": ("seed = 'one'", ["seed: expected a whole number, found 'one'"]),
    "fraction for a whole number": ("seed = 1.5", ["seed: expected a whole number, found 1.5"]),
    "truth value for a number": ("[fleet]\nsettle_s = true", ["fleet.settle_s: expected a number, found true"]),
    "number for a text": ("name = 3", ["name: expected a text, found 3"]),
    "number for a section": ("fleet = 3", ["fleet: expected a table, found 3"]),
    "table for a list": ("[plans]\nattack = 'drift'", ["plans: expected a list"]),
    "number in a list of tables": ("plans = [3]", ["plans.0: expected a table, found 3"]),
    "text for a list": (
        "[detection]\ndetectors = 'lstm_glr'",
        ["detection.detectors: expected a list, found 'lstm_glr'"],
    ),
    "infinite": ("duration_s = inf", ["duration_s: expected a finite number"]),
    "no duration": ("duration_s = 0", ["duration_s: expected more than 0, found 0"]),
    "share over 1": ("[fleet]\nequipped_share = 1.5", ["fleet.equipped_share: expected at most 1, found 1.5"]),
    "nobody equipped": ("[fleet]\nequipped_share = 0", ["fleet.equipped_share: expected more than 0, found 0"]),
    "plan's share over 1": ("[[plans]]\nattack = 'drift'\nshare = 1.5", ["plans.0", "share", "1.5"]),
    "step too long": ("[traffic]\nstep_s = 0.5", ["traffic.step_s: expected at most 0.2, found 0.5"]),
    "negative sublanes": ("[traffic]\nlateral_resolution_m = -1", ["traffic.lateral_resolution_m", "found -1"]),
    "text sublanes": ("[traffic]\nlateral_resolution_m = 'on'", ["traffic.lateral_resolution_m", "'on'"]),
    "unknown association": (
        "[fleet]\nassociation = 'nearst'",
        ["fleet.association", "'nearst'", "did you mean 'nearest'?"],
    ),
    "former name of association": (
        "[fleet]\nmatching = 'nearest'",
        ["fleet", "'matching' is now called 'association'"],
    ),
    "unknown engine": ("engine = 'batch'", ["engine", "'batch'", "did you mean 'batched'?"]),
    "unknown attack": ("[[plans]]\nattack = 'drft'", ["plans.0", "unknown attack 'drft'", "did you mean 'drift'?"]),
    "no attack": ("[[plans]]\nshare = 0.5", ["plans.0", "attack"]),
    "unknown detector": (
        "[detection]\ndetectors = ['cusm']",
        ["detection.detectors", "unknown detector 'cusm'", "did you mean 'cusum'?"],
    ),
    "detector twice": (
        "[detection]\ndetectors = ['cusum', 'cusum']",
        ["detection.detectors", "'cusum' is listed twice"],
    ),
    "no rate": (
        "[detection]\nrates = []",
        ["detection.rates", "expected at least one rate, such as '0.1/h', found none"],
    ),
    "doubled rate": ("[detection]\nrates = ['1/h', '0.1/h', '1/h']", ["detection.rates", "'1/h' is listed twice"]),
    "unknown rate": ("[detection]\nrates = ['1e-3/smple']", ["detection.rates", "1e-3/sample", "by the model"]),
    "former rate": (
        "[detection]\nfalse_alarm_rate = '0.1/h'",
        ["detection.false_alarm_rate", "`rate` of each defence"],
    ),
    "rate between": (
        "[[defences]]\ndetector = 'lstm'\nresponse = 'ukf'\nrate = '0.2/h'",
        ["defences.0.rate", "the nearest is '0.1/h'", "by the model of extreme values: 0.01/h, 1e-3/h"],
    ),
    "rate of told": (
        "[[defences]]\ndetector = 'told'\nresponse = 'ukf'\nrate = '1/h'",
        ["defences.0", "'told' has no calibrated threshold"],
    ),
    "former name of told": (
        "[[defences]]\ndetector = 'oracle'\nresponse = 'ukf'",
        ["defences.0.detector", "'oracle' is called 'told' now"],
    ),
    "unknown detector of a defence": (
        "[[defences]]\ndetector = 'lst'\nresponse = 'ukf'",
        ["defences.0.detector", "unknown detector 'lst'", "did you mean 'lstm'"],
    ),
    "unknown response": (
        "[[defences]]\ndetector = 'lstm_glr'\nresponse = 'ekf'",
        ["defences.0.response", "unknown response 'ekf'", "did you mean 'ukf'?"],
    ),
    "defence without response": ("[[defences]]\ndetector = 'lstm_glr'", ["defences.0.response: is missing"]),
    "defence twice": (
        "[[defences]]\ndetector='lstm_glr'\nresponse='ukf'\n[[defences]]\ndetector='lstm_glr'\nresponse='ukf'",
        ["defences", "'lstm_glr+ukf' is listed twice"],
    ),
    "defence without its detector": (
        "detection.detectors = ['cusum']\n[[defences]]\ndetector = 'lstm_glr'\nresponse = 'ukf'",
        ["defences", "'lstm_glr+ukf'", "detection.detectors"],
    ),
    "plan twice": ("[[plans]]\nattack='drift'\n[[plans]]\nattack='drift'", ["plans", "two plans are called 'drift'"]),
    "plan called none": ("[[plans]]\nattack='drift'\nname='none'", ["plans.0", "name", "'none'"]),
    "unknown profile": ("[fleet]\nprofile = 'carlo'", ["fleet.profile: unknown profile 'carlo'", "'carla'?"]),
    "shares do not add up": (
        "[fleet]\nprofile = {dsd = 0.5, carla = 0.3}",
        ["fleet.profile", "add up to 1, found 0.8"],
    ),
    "negative share": ("[fleet]\nprofile = {dsd = 1.5, carla = -0.5}", ["fleet.profile", "above 0 for 'carla'"]),
    "name with a slash": ("name = '../town'", ["name: expected letters", "'../town'"]),
    "sumocfg that is not there": ("sumocfg = 'twon.sumocfg'", ["sumocfg", "found no file", "twon.sumocfg"]),
    "sumocfg that is no text": ("sumocfg = 3", ["sumocfg: expected a path, found 3"]),
    "no TOML": ("seed = 1 2", ["not valid TOML", "line 1"]),
}


@pytest.mark.parametrize("case", BAD_TOML)
def test_bad_toml(case: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    toml, fragments = BAD_TOML[case]
    make(here, "town", toml)
    monkeypatch.setattr(batch, "run_scenarios", never_run)
    assert cli.main(["run", "town"]) == 2
    said = sentence(capsys)
    assert all(fragment in said for fragment in ["town/gpsec.toml", *fragments]), said
    assert [path.name for path in here.iterdir()] == ["town"]


def test_check_says_every_error_and_no_traceback(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make(here, "a", "sede = 1")
    make(here, "b", "engine = 'x'")
    assert cli.main(["check", "a", "b"]) == 2
    assert [line.split(":")[2].strip() for line in capsys.readouterr().err.splitlines()] == [
        "a/gpsec.toml",
        "b/gpsec.toml",
    ]
