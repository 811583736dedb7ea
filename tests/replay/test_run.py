"""A log through the pipeline: its sensors as they were, attacks in its fixes, tables, figures and a tape."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.hdmap.map import load_map
from gpsec.replay.prepare import lay, order_of, place_order, replay_scenario_of
from gpsec.replay.readers import read_drive
from gpsec.replay.running import replay_log
from gpsec.scenario.overrides import parse_set
from gpsec.types.tapes import read_tape, write_tape
from tests.sensors.test_tapes import recorded

from .logs import csv_log, table, way

DRIVE_S = 30.0
FEW = (
    "fleet.profile=carla",
    "fleet.settle_s=5",
    "detection.detectors=[]",
    "defences=[]",
    "outcomes.bootstrap=20",
    "log_steps=true",
    'plans=[{attack="constant_bias",bias_m=2.0,side="as_given",share=1.0,start_after_s=[5,10],duration_s=[8,8]}]',
)


def replayed(log: Path, folder: Path, *sets: str, net: Path | None = None, copies: int = 2) -> Path:
    order = place_order(log, None, net, copies)
    scenario = replay_scenario_of(order, None, [parse_set(text) for text in (*FEW, *sets)])
    folder.mkdir()
    replay_log(scenario, folder, lambda progress: None)
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("replay")
    return replayed(csv_log(folder, table(way(DRIVE_S))), folder / "out")


def test_measurements_are_the_logs(run):
    """Fixes are off by (0.4, -0.3) m and 1 cm of noise, as the log was made; each copy has the same."""
    steps = pd.read_parquet(run / "steps.parquet")
    honest = steps[steps["plan"] == "none"].dropna(subset=["fix_x_m"])
    off = honest[["fix_x_m", "fix_y_m"]].to_numpy() - honest[["x_m", "y_m"]].to_numpy()
    assert off.mean(axis=0) == pytest.approx([0.4, -0.3], abs=0.01)
    # Carried on over half a step at most by wheels that are 1 % too fast.
    assert off.std(axis=0).max() < 0.02
    one, other = (honest[honest["vehicle_id"] == f"drive-{number}"] for number in (1, 2))
    assert one["fix_x_m"].to_numpy().tolist() == other["fix_x_m"].to_numpy().tolist()
    assert honest["speed_mps"].mean() == pytest.approx(15.0, abs=0.01)


def test_truth_is_the_pose(run):
    steps = pd.read_parquet(run / "steps.parquet")
    one = steps[(steps["plan"] == "none") & (steps["vehicle_id"] == "drive-1")]
    drive = way(DRIVE_S)
    assert one["x_m"].to_numpy() == pytest.approx(np.interp(one["time_s"], drive.time_s, drive.east_m), abs=1e-6)
    assert one["yaw_rad"].to_numpy() == pytest.approx(np.interp(one["time_s"], drive.time_s, drive.yaw_rad), abs=1e-6)
    # The chain goes through the pose: it bends by less than 1 cm within what it is smoothed over.
    assert one["lane_offset_m"].abs().max() < 0.02


def test_attacks_are_in_the_real_fixes(run):
    steps = pd.read_parquet(run / "steps.parquet").set_index(["vehicle_id", "time_s"])
    honest, attacked = (steps[steps["plan"] == plan] for plan in ("none", "constant_bias"))
    attacked = attacked[attacked["attacked"]].dropna(subset=["fix_x_m"])
    honest = honest.loc[attacked.index]
    moved = attacked[["fix_x_m", "fix_y_m"]].to_numpy() - honest[["fix_x_m", "fix_y_m"]].to_numpy()
    yaw = honest["yaw_rad"].to_numpy()
    left = moved[:, 1] * np.cos(yaw) - moved[:, 0] * np.sin(yaw)
    assert left == pytest.approx(2.0, abs=0.01)
    events = pd.read_csv(run / "events.csv")
    assert sorted(set(events["vehicle_id"])) == ["drive-1", "drive-2"]
    assert events["start_s"].nunique() == 2


def test_figures_of_the_errors_stand_beside_the_profiles(run):
    errors = pd.read_csv(run / "errors.csv").fillna({"axis": ""}).set_index(["sensor", "axis", "figure"])
    scale = errors.loc[("odometer", "", "scale - 1")]
    assert scale["value"] == pytest.approx(0.01, abs=0.001)
    assert scale["profile_says"] == 0.01
    white = errors.loc[("gnss", "across", "fix to fix / √2")]
    assert white["value_lo"] < 0.01 < white["value_hi"]
    assert errors.loc[("gnss", "", "rate"), "value"] == pytest.approx(10.0)


def test_the_tape_holds_the_errors_less_their_median(run):
    tape, _ = read_tape(run / "gnss.tape.npz")
    assert tape.rate_hz == pytest.approx(10.0)
    assert tape.median == pytest.approx(np.array([[0.4, -0.3]]), abs=0.003)
    assert np.median(tape.errors[~tape.missing], axis=0) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert tape.errors[~tape.missing].std(axis=0) == pytest.approx([0.01, 0.01], rel=0.2)
    assert tape.provenance["reader"] == "csv"


def test_the_run_says_what_is_missing(run):
    notes = json.loads((run / "manifest.json").read_text())["notes"]
    assert any("not in the log" in note and "heading, camera (lanes)" in note for note in notes)
    assert any("the map is one chain of lanes through its own pose" in note for note in notes)
    assert any("takes part 2 times" in note for note in notes)


def test_a_camera_of_the_log_is_taken_and_makes_the_lane(tmp_path):
    """A lane whose middle lies 0.5 m left of the way: C0 is 0.5, and the vehicle is 0.5 m right of the middle."""
    columns = table(way(DRIVE_S)).assign(c0_m=0.5, c1=0.0, camera_sigma_m=0.05)
    folder = replayed(csv_log(tmp_path, columns), tmp_path / "out", copies=1)
    steps = pd.read_parquet(folder / "steps.parquet")
    honest = steps[steps["plan"] == "none"]
    assert honest["lane_offset_m"].to_numpy()[20:-20] == pytest.approx(-0.5, abs=0.03)
    assert honest["camera_offset_m"].dropna().to_numpy() == pytest.approx(-0.5)
    # z = d_camera - d_map(fix): how far the fix is to the left, turned round.
    yaw = honest["yaw_rad"].to_numpy()
    left = -0.3 * np.cos(yaw) - 0.4 * np.sin(yaw)
    assert (honest["residual_m"] + left).abs().median() < 0.03


def test_a_lane_change_blinds_the_camera_for_a_while(tmp_path):
    drive = way(DRIVE_S)
    # The line is crossed at 15 s: from then on the camera shows the lane to the left.
    columns = table(drive).assign(c0_m=np.where(drive.time_s < 15.0, 1.6, -1.6))
    laid = lay(read_drive(csv_log(tmp_path, columns), "csv"))
    assert laid.chain.changes == 1
    blind = np.flatnonzero(~laid.drive.lane_there)
    assert (blind.min(), blind.max()) == pytest.approx((120, 179), abs=1)


def test_the_same_log_gives_the_same_bytes_for_two_threads(tmp_path):
    log = csv_log(tmp_path, table(way(DRIVE_S)))
    one, two = (replayed(log, tmp_path / str(n), f"threads={n}") for n in (1, 2))
    for name in ("events.csv", "vehicles.csv", "errors.csv", "gnss.tape.npz"):
        assert (one / name).read_bytes() == (two / name).read_bytes()


def test_both_engines_see_the_same_with_a_tape_for_the_camera(tmp_path):
    log = csv_log(tmp_path, table(way(DRIVE_S)))
    write_tape(recorded(pieces=3), tmp_path / "tape.npz")
    tape = f'fleet.camera.tape="{tmp_path / "tape.npz"}"'
    sets = ('detection.detectors=["chi_square"]', 'detection.rates=["1e-3/sample"]', tape)
    one, other = (replayed(log, tmp_path / engine, f"engine={engine}", *sets) for engine in ("batched", "reference"))
    events = [pd.read_csv(folder / "events.csv") for folder in (one, other)]
    pd.testing.assert_frame_equal(*events, rtol=1e-6)


FCD_NET = ('id="a" x="0" y="0"\nid="b" x="600" y="0"', 'id="ab" from="a" to="b" speed="13.9"')


def fcd(path: Path, gap: bool = False) -> Path:
    """One vehicle at 12 m/s and 0.3 m left of the middle of the only lane, and one that jumps after 10 s."""
    lines = ["<fcd-export>"]
    for number in range(300):
        time_s = 0.1 * number + (5.0 if gap and number > 100 else 0.0)
        jump_m = 50.0 if number > 100 else 0.0
        lines.append(f'<timestep time="{time_s:.2f}">')
        for name, x in (("steady", 20.0 + 1.2 * number), ("jumper", 5.0 + 1.2 * number + jump_m)):
            lines.append(f'<vehicle id="{name}" x="{x:.2f}" y="-1.3" angle="90" type="car" speed="12" lane="ab_0"/>')
        lines.append("</timestep>")
    path.write_text("\n".join([*lines, "</fcd-export>"]))
    return path


def test_fcd_is_traffic(tmp_path, plain_net):
    net = plain_net(*FCD_NET)
    folder = replayed(fcd(tmp_path / "fcd.xml"), tmp_path / "out", net=net)
    vehicles = pd.read_csv(folder / "vehicles.csv")
    assert sorted(set(vehicles["vehicle_id"])) == ["jumper", "jumper#2", "steady"]
    steps = pd.read_parquet(folder / "steps.parquet")
    steady = steps[(steps["plan"] == "none") & (steps["vehicle_id"] == "steady")]
    assert steady["lane_offset_m"].to_numpy() == pytest.approx(0.3, abs=1e-6)
    assert steady["speed_mps"].to_numpy()[1:] == pytest.approx(12.0, abs=1e-6)
    assert not (folder / "errors.csv").exists()


def test_fcd_with_steps_missing_or_of_another_net_is_refused(tmp_path, plain_net):
    net = plain_net(*FCD_NET)
    with pytest.raises(GpsecError, match=r"steps are missing: expected the step 10\.1 s, found 15\.1 s"):
        replayed(fcd(tmp_path / "fcd.xml", gap=True), tmp_path / "out", net=net)
    far = plain_net('id="a" x="9000" y="0"\nid="b" x="9600" y="0"', FCD_NET[1])
    with pytest.raises(GpsecError, match="expected positions within the net"):
        replayed(fcd(tmp_path / "fcd.xml"), tmp_path / "far", net=far)
    with pytest.raises(GpsecError, match="expected --net with the net that this traffic drove on"):
        place_order(tmp_path / "fcd.xml", None, None, 1)


def test_the_chain_is_a_net(tmp_path):
    scenario = replay_scenario_of(place_order(csv_log(tmp_path), None, None, 1), None, [])
    hd_map = load_map(scenario.sumocfg.with_name("chain.net.xml"), (1.0,))
    assert len(hd_map.lane_ids) > 1
    assert not hd_map.sides.internal.any()
    assert hd_map.sides.width_m == pytest.approx(3.5)


def test_a_log_that_has_changed_is_not_run(tmp_path):
    log = csv_log(tmp_path)
    scenario = replay_scenario_of(place_order(log, None, None, 1), None, [])
    assert order_of(scenario) is not None
    csv_log(tmp_path, table(seed=3))
    with pytest.raises(GpsecError, match="the log has changed since"):
        order_of(scenario)


def test_a_log_in_closed_loop_is_refused(tmp_path):
    """By the command line and by a file, each in one sentence that names where it stands."""
    log = csv_log(tmp_path)
    order = place_order(log, None, None, 1)
    said = "closed_loop: expected no such section for a replay, found one: recorded traffic cannot react"
    with pytest.raises(GpsecError) as caught:
        replay_scenario_of(order, None, [parse_set("closed_loop.on_alarm=stop")])
    assert str(caught.value) == f"{log.resolve()}: {said}"
    config = tmp_path / "gpsec.toml"
    config.write_text("[closed_loop]\nseeds = 2\n")
    with pytest.raises(GpsecError) as caught:
        replay_scenario_of(order, config, [])
    assert str(caught.value) == f"{config}: {said}"
