from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from gpsec.detection.logs import Grid, ResidualLog
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.tapes import Tapes
from gpsec.traffic.recording import Recording
from gpsec.training.collect import record_scenario, recorded_traffic, residual_log
from gpsec.types.tapes import Tape

# Three lanes, straight; some 250 vehicles that overtake each other.
NODES = 'id="a" x="0" y="0"\nid="b" x="1500" y="400"'
EDGE = 'id="ab" from="a" to="b" numLanes="3" speed="33.3"'
ROUTES = """<routes>
  <vType id="car" maxSpeed="40" speedFactor="normc(1,0.15,0.7,1.3)" lcSigma="0.2"/>
  <flow id="f" type="car" begin="0" end="200" period="0.5" departLane="random" departSpeed="desired">
    <route edges="ab"/>
  </flow>
</routes>"""


@pytest.fixture(scope="module")
def net(plain_net) -> Path:
    return plain_net(NODES, EDGE)


@pytest.fixture(scope="module")
def recordings(net, tmp_path_factory) -> list[Path]:
    """The same traffic, recorded twice."""
    folder = tmp_path_factory.mktemp("road")
    (folder / "cars.rou.xml").write_text(ROUTES)
    config = folder / "road.sumocfg"
    inputs = f'<net-file value="{net}"/><route-files value="cars.rou.xml"/>'
    config.write_text(f'<configuration><input>{inputs}</input><time><end value="200"/></time></configuration>')
    files = [folder / f"{number}.npz" for number in range(2)]
    for file in files:
        record_scenario(config, 5, file)
    return files


def camera_tape(rate_hz: float = 10.0) -> Tape:
    """C0 is off by 0.1 m, to either side in turn, and the camera states 0.125 m."""
    errors = np.zeros((100, 4))
    errors[:, 0] = np.resize([0.1, -0.1], 100)
    none, first = np.zeros(100, np.bool_), np.zeros(1, np.int64)
    return Tape("camera", rate_hz, errors, none, np.full(100, 0.125), first, np.zeros((1, 4)), "test", {})


def log(recordings, net, profile="carla", association="tracked", seed=3) -> ResidualLog:
    return residual_log(recorded_traffic(recordings[0], net), net, "road", PROFILES[profile], association, seed)


def columns(one: ResidualLog) -> list[bytes]:
    arrays = (getattr(one, field.name) for field in fields(one))
    return [array.tobytes() for array in arrays if isinstance(array, np.ndarray)]


def test_recorded_traffic_is_deterministic(recordings, net):
    first, second = (recorded_traffic(file, net) for file in recordings)
    assert len(first.vehicle_id) > 200
    for field in fields(Recording):
        assert getattr(first, field.name).tobytes() == getattr(second, field.name).tobytes(), field.name


# What receivers share has another sign for each direction of the road.
@pytest.mark.parametrize("profile", [name for name, of in PROFILES.items() if of.gnss.common_share is None])
def test_on_a_straight_road_the_residual_is_as_large_as_the_profile_promises(recordings, net, profile):
    """Biases and mounting offsets last, so that the vehicles count, not the samples."""
    found = log(recordings, net, profile)
    z = found.residual_m[found.valid] / found.scale_m
    vehicles = len(np.unique(found.vehicle))
    assert vehicles > 200
    # Four standard errors of a standard deviation, and of a mean from so many independent vehicles.
    assert z.std() == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * vehicles))
    assert abs(z.mean()) < 4.0 / np.sqrt(vehicles)


def test_log_is_what_training_reads(recordings, net):
    found = log(recordings, net)
    assert (found.network, found.profile, found.association, found.step_s) == ("road", "carla", "tracked", 0.1)
    order = np.lexsort((found.step, found.vehicle))
    assert order.tolist() == list(range(len(order)))
    assert len(np.unique(np.stack([found.vehicle, found.step]), axis=1).T) == len(found.step)
    assert (found.residual_m[~found.valid] == 0.0).all()
    assert 0.9 < found.valid.mean() < 1.0  # the camera's outages
    # Seen on a straight road: no curve but noise.
    assert abs(found.curvature_per_m[found.valid].mean()) < 1e-4
    assert Grid.of([found]).residual_m.shape[1] == len(np.unique(found.vehicle))


def test_log_is_deterministic_and_the_seed_counts(recordings, net):
    assert columns(log(recordings, net)) == columns(log(recordings, net))
    other = log(recordings, net, seed=4)
    assert not np.array_equal(other.residual_m, log(recordings, net).residual_m)


def test_the_nearest_lane_folds_what_the_oracle_sees(recordings, net):
    """With an error of metres, the next lane is often the nearest: residuals stay within half a lane."""
    tracked, nearest = (log(recordings, net, "urban", association) for association in ("oracle", "nearest"))
    assert abs(tracked.residual_m).max() > 4.0
    # On the lanes between others; outside the road there is nothing to fold into.
    assert np.percentile(abs(nearest.residual_m), 90) < np.percentile(abs(tracked.residual_m), 90)
    assert nearest.scale_m == tracked.scale_m


def test_vehicles_that_own_the_same_row_are_told_apart(recordings, net):
    recording = recorded_traffic(recordings[0], net)
    assert len(np.unique(recording.departure_row)) < len(recording.departure_row)
    found = log(recordings, net)
    assert len(np.unique(found.vehicle)) == len(recording.departure_row)


def test_sensors_play_the_tapes_that_they_are_given(recordings, net):
    recording = recorded_traffic(recordings[0], net)
    tape = camera_tape()
    played = residual_log(recording, net, "road", PROFILES["dsd"], "tracked", 3, tapes=Tapes(camera=tape))
    plain = residual_log(recording, net, "road", PROFILES["dsd"], "tracked", 3)
    np.testing.assert_allclose(played.camera_sigma_m[played.valid], 0.125)
    assert not np.isclose(plain.camera_sigma_m[plain.valid], 0.125).any()
    assert (played.residual_m[played.valid & plain.valid] != plain.residual_m[played.valid & plain.valid]).mean() > 0.99
