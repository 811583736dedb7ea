import json
import re
from pathlib import Path

import pytest
from pydantic import ValidationError

from gpsec.attacks.registry import ATTACKS
from gpsec.core.errors import GpsecError
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.overrides import Override, parse_set
from gpsec.sumo.home import sumo_home

ROOT = Path(__file__).parent.parent
BUNDLED = sorted((ROOT / "scenarios").glob("*/gpsec.toml"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "ring"
    made.mkdir()
    (made / "traffic.sumocfg").write_text("<sumoConfiguration/>")
    return made


def load(folder: Path, toml: str = "", *sets: str) -> Scenario:
    (folder / "gpsec.toml").write_text(toml)
    return load_scenario(folder, [parse_set(text) for text in sets])


def test_a_folder_its_toml_and_its_sumocfg_stand_for_the_same_traffic(folder: Path) -> None:
    from_sumocfg = load_scenario(folder / "traffic.sumocfg")
    from_bare_folder = load_scenario(folder)
    from_folder = load(folder, "seed = 5")
    from_toml = load_scenario(folder / "gpsec.toml")
    assert from_folder == from_toml
    everything = (from_sumocfg, from_bare_folder, from_folder, from_toml)
    assert {found.sumocfg for found in everything} == {folder / "traffic.sumocfg"}
    assert [found.name for found in everything] == ["traffic", "ring", "ring", "ring"]
    # A .sumocfg alone does not read the file beside it.
    assert [found.seed for found in (load_scenario(folder / "traffic.sumocfg"), from_toml)] == [1, 5]


def test_sumocfg_is_relative_to_the_toml_and_may_start_at_sumo(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "other.sumocfg").write_text("<sumoConfiguration/>")
    assert load(folder, 'sumocfg = "../other.sumocfg"').sumocfg == tmp_path / "other.sumocfg"
    wheel = load(folder, 'sumocfg = "$SUMO_HOME/tools/game/A10KW.sumocfg"')
    assert wheel.sumocfg == (sumo_home() / "tools/game/A10KW.sumocfg").resolve()
    plain = wheel.model_dump(mode="json")
    assert plain["sumocfg"] == "$SUMO_HOME/tools/game/A10KW.sumocfg"
    assert Scenario.model_validate(plain) == wheel


@pytest.mark.parametrize("ending", [".sumocfg", ".sumocfg.xml", ".sumo.cfg", ".sumocfg.disabled"])
def test_configurations_by_all_their_names(tmp_path: Path, ending: str) -> None:
    config = tmp_path / f"old.town{ending}"
    config.write_text("<configuration/>")
    scenario = load_scenario(config)
    assert (scenario.name, scenario.sumocfg) == ("old.town", config)


def test_a_name_that_no_folder_may_have_is_cleaned(tmp_path: Path) -> None:
    made = tmp_path / "my town (2)"
    made.mkdir()
    (made / "a.sumocfg").write_text("<sumoConfiguration/>")
    assert load_scenario(made).name == "my_town_2"


def test_command_line_wins_over_file_wins_over_defaults(folder: Path) -> None:
    toml = "seed = 5\nduration_s = 60.0\n[fleet]\nsettle_s = 3\nassociation = 'nearest'"
    flag = Override(("seed",), 7, "--seed 7")
    (folder / "gpsec.toml").write_text(toml)
    scenario = load_scenario(folder, [parse_set("fleet.settle_s=4"), flag])
    assert (scenario.seed, scenario.fleet.settle_s) == (7, 4.0)  # flag over file
    assert (scenario.duration_s, scenario.fleet.association) == (60.0, "nearest")  # file over default
    assert (scenario.threads, scenario.fleet.equipped_share) == (1, 1.0)  # default


def test_the_later_of_two_flags_wins(folder: Path) -> None:
    assert load(folder, "", "seed=2", "seed=3").seed == 3


def test_defaults_are_every_attack_and_a_defence_for_each_detector(folder: Path) -> None:
    scenario = load(folder)
    assert [defence.name for defence in scenario.defences] == [
        "never+none",
        "told+ukf",
        "chi_square+ukf",
        "cusum+ukf",
        "isolation_forest+ukf",
        "lstm_glr+ukf",
        "innovation+ukf",
        "joint+ukf",
    ]
    assert {plan.attack for plan in scenario.plans} == set(ATTACKS) - {"adaptive"} >= {"constant_bias", "lane_alias"}
    assert {plan.share for plan in scenario.plans} == {0.5}
    assert scenario.fleet.profile == {"carla": 1.0}


def test_default_defences_follow_the_detectors(folder: Path) -> None:
    scenario = load(folder, "[detection]\ndetectors = ['cusum']")
    assert [defence.name for defence in scenario.defences] == ["never+none", "told+ukf", "cusum+ukf"]


@pytest.mark.parametrize(
    "toml",
    [
        "[[defences]]\ndetector = 'lstm_glr'\nresponse = 'ukf'",
        "[[defences]]\ndetector='lstm_glr'\nresponse='ukf'\n[[defences]]\ndetector='never'\nresponse='none'",
    ],
)
def test_the_undefended_vehicle_is_always_the_first_defence(folder: Path, toml: str) -> None:
    assert [defence.name for defence in load(folder, toml).defences] == ["never+none", "lstm_glr+ukf"]


def test_set_takes_toml_values_and_bare_words(folder: Path) -> None:
    scenario = load(
        folder,
        "",
        "fleet.profile={dsd = 0.25, carla = 0.75}",
        "fleet.association=nearest",
        "traffic.lateral_resolution_m=0.4",
        "detection.detectors=['cusum', 'lstm_glr']",
        "detection.rates=['1e-4/sample']",
        "log_steps=true",
        "duration_s=12.5",
    )
    assert scenario.fleet.profile == {"dsd": 0.25, "carla": 0.75}
    assert (scenario.fleet.association, scenario.traffic.lateral_resolution_m) == ("nearest", 0.4)
    assert scenario.detection.detectors == ("cusum", "lstm_glr")
    assert scenario.detection.rates == ("1e-4/sample",)
    assert (scenario.log_steps, scenario.duration_s) == (True, 12.5)


def test_none_takes_back_what_the_file_sets(folder: Path) -> None:
    assert load(folder, "duration_s = 60", "duration_s=none").duration_s is None


def test_set_reaches_into_lists_by_position_and_by_name(folder: Path) -> None:
    toml = "[[plans]]\nattack = 'drift'\n[[plans]]\nattack = 'drift'\nname = 'fast'\nrate_mps = 0.4"
    changes = ("plans.0.rate_mps=0.1", "plans.fast.share=0.25", "plans.2.attack=jamming", "defences.5.response=none")
    scenario = load(folder, toml, *changes)
    assert [(plan.name, plan.share) for plan in scenario.plans] == [("drift", 0.5), ("fast", 0.25), ("jamming", 0.5)]
    assert [getattr(plan.parameters, "rate_mps", None) for plan in scenario.plans] == [0.1, 0.4, None]
    assert scenario.defences[5].name == "lstm_glr+none"


def test_set_changes_a_default_plan(folder: Path) -> None:
    plans = {plan.name: plan for plan in load(folder, "", "plans.constant_bias.bias_m=3").plans}
    assert plans["constant_bias"].parameters.bias_m == 3.0
    assert len(plans) == len(ATTACKS) - 1  # adaptive is asked for by name


def test_json_and_back(folder: Path) -> None:
    toml = "[fleet]\nprofile = {dsd = 0.5, carla = 0.5}\n[[plans]]\nattack = 'drift'\nrate_mps = 0.4"
    scenario = load(folder, toml)
    plain = json.loads(json.dumps(scenario.model_dump(mode="json")))
    assert Scenario.model_validate(plain) == scenario
    assert plain["plans"][0]["parameters"]["rate_mps"] == 0.4


@pytest.mark.parametrize("toml", BUNDLED, ids=[path.parent.name for path in BUNDLED])
def test_text_in_json_means_the_same_in_any_folder(toml: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    sets = ["fleet.profile={dsd=0.5, carla=0.5}", "plans=[{attack='drift', share=0.2, duration_s=[3, 4]}]"]
    for scenario in (load_scenario(toml), load_scenario(toml, [parse_set(text) for text in sets])):
        text = scenario.model_dump_json()
        with monkeypatch.context() as elsewhere:
            elsewhere.chdir(tmp_path)
            assert Scenario.model_validate_json(text) == scenario


def test_paths_in_json_are_absolute_and_in_a_manifest_relative(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder.parent)
    (folder / "models").mkdir()
    scenario = load(folder, "detection.models = 'models'")
    assert json.loads(scenario.model_dump_json())["sumocfg"] == str(folder / "traffic.sumocfg")
    assert scenario.stated()["sumocfg"] == "ring/traffic.sumocfg"
    assert scenario.detection.models == str(folder / "models")
    monkeypatch.chdir("/")
    assert Scenario.model_validate_json(scenario.model_dump_json()) == scenario


def test_a_scenario_is_frozen(folder: Path) -> None:
    scenario = load(folder)
    with pytest.raises(ValidationError):
        scenario.seed = 2  # type: ignore[misc]
    with pytest.raises(ValidationError):
        scenario.fleet.settle_s = 2.0  # type: ignore[misc]


@pytest.mark.parametrize("toml", BUNDLED, ids=lambda path: path.parent.name)
def test_bundled_scenarios_have_every_attack_and_the_defences(toml: Path) -> None:
    scenario = load_scenario(toml.parent)
    assert scenario.name == toml.parent.name
    assert len({plan.attack for plan in scenario.plans}) == 8
    names = [defence.name for defence in scenario.defences]
    assert names[:2] == ["never+none", "told+ukf"]
    assert {"chi_square+ukf", "cusum+ukf", "isolation_forest+ukf", "lstm_glr+ukf", "lstm_glr+dead_reckoning"} <= set(
        names
    )


def test_there_are_seven_bundled_scenarios() -> None:
    assert len(BUNDLED) == 7


BAD_SETS = {
    "seed": "expected key=value",
    "=3": "expected key=value",
    "fleet..profile=dsd": "expected key=value",
    "fleet.profile=": "expected a TOML value",
    "plans=[{attack=}]": "expected a TOML value",
    "plans.99.share=1": f"expected a position from 0 to {len(ATTACKS) - 1} in plans, found 99",
    "plans.drfit.share=1": "plans has nothing called 'drfit': did you mean 'drift'?",
    "seed.deeper=1": "seed is neither a table nor a list",
}


@pytest.mark.parametrize(("text", "said"), BAD_SETS.items())
def test_bad_set(folder: Path, text: str, said: str) -> None:
    with pytest.raises(GpsecError, match=re.escape(said)) as caught:
        load(folder, "seed = 1", text)
    assert f"--set {text}" in str(caught.value)


def test_an_error_names_the_flag_that_wrote_the_key_and_else_the_file(folder: Path) -> None:
    with pytest.raises(GpsecError, match=re.escape("--set seed=-1: seed: expected at least 0, found -1")):
        load(folder, "seed = 1", "seed=-1")
    with pytest.raises(GpsecError, match=r"gpsec\.toml: seed: expected at least 0, found -1"):
        load(folder, "seed = -1", "fleet.settle_s=1")
    plan = "[[plans]]\nattack = 'drift'\nrate_mps = 9.0"
    with pytest.raises(GpsecError, match=r"gpsec\.toml: plans\.0: rate_mps"):
        load(folder, plan, "plans.0.share=0.1")
    with pytest.raises(GpsecError, match=r"--set plans\.drift\.rate_mps=8: plans\.0: rate_mps"):
        load(folder, plan, "plans.drift.rate_mps=8")


def test_models_may_lie_in_another_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "own").mkdir()
    (folder.parent / "flag").mkdir()
    monkeypatch.chdir(folder.parent)
    assert load(folder).detection.models is None
    assert load(folder, "detection.models = 'own'").detection.models == str(folder / "own")
    # In a flag, from where the user is.
    assert load(folder, "detection.models = 'own'", "detection.models=flag").detection.models == str(
        folder.parent / "flag"
    )
    assert load(folder, "detection.models = 'own'", "detection.models=none").detection.models is None
    with pytest.raises(GpsecError, match=r"gpsec\.toml: detection\.models: expected a folder with models, found none"):
        load(folder, "detection.models = 'flag'")
