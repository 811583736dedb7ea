"""When an attack is over: the estimate converges, and the vehicle is in its lane again, in SUMO's hands or its own."""

from collections import defaultdict

import numpy as np
import pandas as pd
import pytest

from gpsec.pipeline.run import run_scenario

from .test_closed_loop import worlds

PLAN = 'plans=[{attack="constant_bias",share=0.5,bias_m=1.5,start_after_s=[1.0,2.0],duration_s=[8.0,8.0]}]'
UNDEFENDED = 'closed_loop.worlds=[{plan="constant_bias",defence="never+none"}]'
# Half a minute at most the estimate is waited for; of carla it is back within seconds, and so is the vehicle.
BACK_S = 15.0


class Witness:
    """Writes down error, place across the lane and attack of every vehicle in every step."""

    def __init__(self):
        self.seen = defaultdict(list)

    def begin(self, study):
        pass

    def see(self, view, outcomes, fleet):
        for track in view.rows.tolist():
            row = int(view.tracks.vehicle[track])
            off_m = view.answers.estimate_m[track, 0] - view.vehicles.rear_m[row]
            yaw = view.vehicles.lane_yaw_rad[row]
            error_m = np.cos(yaw) * off_m[1] - np.sin(yaw) * off_m[0]
            now = (view.time_s, bool(view.tracks.attacked[track]), error_m, view.vehicles.lane_offset_m[row])
            self.seen[fleet[row].vehicle_id].append(now)


@pytest.mark.parametrize("steer", ["attacked", pytest.param("all", marks=pytest.mark.slow)])
def test_who_was_attacked_returns_to_the_lane_and_knows_it(repository, tmp_path, steer):
    made = worlds(repository, PLAN, "duration_s=45.0", f"closed_loop.steer={steer}", UNDEFENDED)
    (world,) = (each for each in made if each.closed_loop.world.plan == "constant_bias")
    witness = Witness()
    run_scenario(world, tmp_path, lambda progress: None, onlooker=witness)
    stories = pd.read_csv(tmp_path / "events.csv").drop_duplicates("vehicle_id").set_index("vehicle_id")
    followed = 0
    for name, steps in witness.seen.items():
        time_s, attacked, error_m, place_m = map(np.array, zip(*steps, strict=True))
        if not attacked.any() or attacked[-1] or stories["crash_s"].notna()[name]:
            continue
        end_s = time_s[attacked].max()
        assert np.abs(place_m[attacked]).max() > 0.8
        after = time_s > end_s + BACK_S
        if after.any():
            followed += 1
            assert np.abs(error_m[after]).max() < 0.5
            assert np.abs(place_m[after]).max() < 0.5
            assert stories["released_s"].notna()[name] == (steer == "attacked")
    assert followed >= 3
