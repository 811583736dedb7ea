"""`--seeds`: a run for each, in one folder, with tables over all."""

from pathlib import Path

import pytest

import gpsec
from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.running.seeds import parse_seeds, with_seeds


def test_seeds_are_numbers_and_ranges() -> None:
    assert parse_seeds("1-3") == (1, 2, 3)
    assert parse_seeds("9, 1,4-5") == (1, 4, 5, 9)


@pytest.mark.parametrize("text", ["", "1-", "3-1", "a", "1,1", "0-5000", "-3", "1.5"])
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(GpsecError, match=r"^seeds: expected"):
        parse_seeds(text)


def test_each_seed_is_a_scenario_with_a_name_of_its_own() -> None:
    scenario = gpsec.read_scenario("slow_curve", plans={"drift": {"rate_mps": 0.3}})
    made = with_seeds(scenario, (3, 8))
    assert [(one.name, one.seed) for one in made] == [("slow_curve-seed-3", 3), ("slow_curve-seed-8", 8)]
    assert all(one.plans == scenario.plans and one.defences == scenario.defences for one in made)
    assert with_seeds(scenario, ()) == [scenario]


def test_seed_and_seeds_exclude_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", "slow_curve", "--seed", "1", "--seeds", "1-2"]) == 2
    assert "--seeds 1-2: expected it without --seed" in capsys.readouterr().err


def test_two_seeds_end_in_one_folder(tmp_path: Path) -> None:
    keys = {"duration_s": 25.0, "fleet": {"settle_s": 5.0}, "outcomes": {"bootstrap": 20}}
    run = gpsec.run("slow_curve", tmp_path / "made", seeds="1-2", **keys)
    assert [stated["scenario"] for stated in run.scenarios] == ["slow_curve-seed-1", "slow_curve-seed-2"]
    over = run.over_seeds()
    assert over is not None
    hours = run.detection.drop_duplicates("scenario")["vehicle_hours"].sum()
    assert over.detection["vehicle_hours"].iloc[0] == pytest.approx(hours)
    assert set(over.safety["scenario"]) == {"slow_curve"}
    assert run.changed == {}
    assert "<option>slow_curve · dsd" in (gpsec_report(run)).read_text("utf-8")


def gpsec_report(run: gpsec.Results) -> Path:
    from gpsec.report.make import write_report

    return write_report(run)
