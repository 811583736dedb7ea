"""What is found does not depend on how the clocks of the sensors fall on steps."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gpsec.attacks.plans import plan_config
from gpsec.pipeline.run import run_scenario
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.traffic.offline import OfflineTraffic
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.source import Departure, Equip, Frame
from gpsec.types.points import point_name

DURATION_S = 15.0
SPEED_MPS = 12.0
VEHICLES = 12
DETECTORS = ("chi_square", "cusum", "isolation_forest", "lstm_glr")
RATE = "1e-3/sample"
# A sudden bias of half a lane that begins after three to five seconds and is over after four.
PLAN = {
    "attack": "constant_bias",
    "bias_m": 2.4,
    "share": 1.0,
    "start_after_s": [0.0, 2.0],
    "duration_s": [4.0, 4.0],
}


class Column(OfflineTraffic):
    """Vehicles one behind the other in the middle of a long lane; implements `gpsec.pipeline.interfaces.Traffic`."""

    def __init__(self, options: SumoOptions, lane_index: Mapping[str, int], equip: Equip) -> None:
        super().__init__(options)
        self.step_s = options.step_s
        self._lane = lane_index["ab_0"]

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        rows = np.arange(VEHICLES, dtype=np.int32)
        for step in range(round(DURATION_S / self.step_s)):
            time_s = (step + 1) * self.step_s
            x_m = 20.0 + 15.0 * rows + SPEED_MPS * time_s
            yield Frame(
                step=step,
                time_s=time_s,
                left=[],
                departures=[_departure(row) for row in rows.tolist()] if step == 0 else [],
                rows=rows,
                front_m=np.stack([x_m, np.full(VEHICLES, -1.6)], axis=1),
                lane=np.full(VEHICLES, self._lane, np.int32),
                on_road=VEHICLES,
            )


def _departure(row: int) -> Departure:
    return Departure(row, f"car {row}", "car", "passenger", 4.5, 1.8, 0.0, SPEED_MPS, None, None)


Events = Callable[[float, str], pd.DataFrame]


@pytest.fixture(scope="module")
def events(plain_net, tmp_path_factory: pytest.TempPathFactory) -> Events:
    """Return a function that gives the attacked vehicles of a run with steps of that length and of a profile."""
    net: Path = plain_net('id="a" x="0" y="0"\nid="b" x="900" y="0"', 'id="ab" from="a" to="b" speed="30"')
    (net.parent / "column.rou.xml").write_text('<routes><vType id="car"/></routes>')
    config = net.parent / "column.sumocfg"
    inputs = f'<net-file value="{net.name}"/><route-files value="column.rou.xml"/>'
    config.write_text(f"<configuration><input>{inputs}</input></configuration>")
    kept: dict[tuple[float, str], pd.DataFrame] = {}

    def give(step_s: float, profile: str) -> pd.DataFrame:
        if (step_s, profile) not in kept:
            folder = tmp_path_factory.mktemp("steps")
            run_scenario(_scenario(config, step_s, profile), folder, lambda progress: None, Column)
            kept[step_s, profile] = pd.read_csv(folder / "events.csv")
        return kept[step_s, profile]

    return give


def _scenario(config: Path, step_s: float, profile: str) -> Scenario:
    scenario = load_scenario(config)
    changes = {
        "seed": 3,
        "duration_s": DURATION_S,
        "traffic": scenario.traffic.model_copy(update={"step_s": step_s}),
        "fleet": scenario.fleet.model_copy(update={"settle_s": 3.0, "profile": {profile: 1.0}}),
        "detection": scenario.detection.model_copy(update={"detectors": DETECTORS}),
        "defences": (
            Defence(detector="never", response="none"),
            *(Defence(detector=one, response="ukf", rate=RATE) for one in DETECTORS),
        ),
        "plans": (plan_config(PLAN, "steps"),),
        "outcomes": scenario.outcomes.model_copy(update={"bootstrap": 10}),
    }
    return scenario.model_copy(update=changes)


@pytest.mark.parametrize("step_s", [0.05, 0.033, 0.02, 0.01, 0.005])
def test_a_sudden_bias_is_detected_alike_at_every_step(events: Events, step_s: float):
    """GNSS and camera of 20 Hz have hardly a sample in the same step of 10 ms, and none in one of 5 ms."""
    long, short = events(0.1, "carla"), events(step_s, "carla")
    assert len(long) == len(short) == VEHICLES * (1 + len(DETECTORS))
    for detector in DETECTORS:
        one, other = (table[table["detector"] == point_name(detector, RATE)] for table in (long, short))
        assert one["detected"].mean() == other["detected"].mean() == 1.0
        # At 0.1 s an attack begins with a sample. At shorter steps it waits 0.05 s for one, and the forest needs a
        # second one of some; one or two vehicles are without a camera just then.
        assert other["detection_delay_s"].median() <= one["detection_delay_s"].median() + 0.15 <= 0.15
        scored = [(table["true_positives"] + table["false_negatives"]).sum() for table in (one, other)]
        assert scored[1] == pytest.approx(scored[0], rel=0.06)
        # The attack never gets hold of the vehicle, and GNSS is trusted again when it is over.
        assert other["max_cross_track_m"].max() < 0.9
        assert other["time_to_retrust_s"].notna().all()


def test_sensors_that_are_late_by_several_steps_can_be_run(events: Events):
    """Odometer and gyro of `consumer` are late by 20 ms, and it has half as many residuals, at any step."""
    long, short = events(0.1, "consumer"), events(0.01, "consumer")
    scored = [(table["true_positives"] + table["false_negatives"]).sum() for table in (long, short)]
    assert 0.4 < scored[0] / len(long) / 40.0 < 0.6
    assert scored[1] == pytest.approx(scored[0], rel=0.15)
