"""The truth is driveable: its own speed and yaw rate lead along its own path."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.pipeline.build import lay_ground
from gpsec.scenario import load_scenario
from gpsec.traffic.body import advance, axle_distance
from gpsec.traffic.recording import Recording, record_traffic
from gpsec.traffic.session import SumoSession
from gpsec.types.vehicles import Vehicles

SETTLED, AHEAD = 100, 100  # steps


@dataclass
class Journey:
    """(T,) steps of one vehicle."""

    east_m: list[float]
    north_m: list[float]
    yaw_rad: list[float]
    speed_mps: list[float]
    yaw_rate_rps: list[float]


def journeys(recording: Recording) -> list[Journey]:
    """Drive the bodies as the pipeline does; one journey for every vehicle."""
    bodies, step_s = Table(Vehicles, int(recording.rows.max()) + 1), float(recording.step_s[0])
    vehicles = bodies.now
    done: list[Journey] = []
    on_road: dict[int, Journey] = {}
    for number in range(len(recording)):
        frame = recording.frame(number)
        for departure in frame.departures:
            row = np.array([departure.row], np.int32)
            bodies.reset(row)
            vehicles.yaw_rad[row] = departure.yaw_rad
            vehicles.speed_mps[row] = departure.speed_mps
            vehicles.axle_m[row] = axle_distance(departure.length_m)
            on_road[departure.row] = Journey([], [], [], [], [])
            done.append(on_road[departure.row])
        advance(frame.rows, frame.front_m, step_s, vehicles)
        for row in frame.rows.tolist():
            journey = on_road[row]
            journey.east_m.append(vehicles.rear_m[row, 0])
            journey.north_m.append(vehicles.rear_m[row, 1])
            journey.yaw_rad.append(vehicles.yaw_rad[row])
            journey.speed_mps.append(vehicles.speed_mps[row])
            journey.yaw_rate_rps.append(vehicles.yaw_rate_rps[row])
    return done


def final_errors_m(journey: Journey, step_s: float) -> np.ndarray:
    """Error after ten seconds of dead reckoning with perfect sensors, for every start after settling."""
    path = {name: np.array(values) for name, values in vars(journey).items()}
    starts = np.arange(SETTLED, len(path["east_m"]) - AHEAD)
    x, y, yaw = path["east_m"][starts], path["north_m"][starts], path["yaw_rad"][starts]
    for ahead in range(1, AHEAD + 1):
        turn = path["yaw_rate_rps"][starts + ahead] * step_s
        # Exact for a constant turn rate: the chord of an arc is sinc(turn / 2) as long, np.sinc(u) = sin(πu)/(πu).
        chord = path["speed_mps"][starts + ahead] * step_s * np.sinc(turn / 2.0 / np.pi)
        x, y, yaw = x + chord * np.cos(yaw + turn / 2.0), y + chord * np.sin(yaw + turn / 2.0), yaw + turn
    return np.hypot(x - path["east_m"][starts + AHEAD], y - path["north_m"][starts + AHEAD])


def measure(folder: Path, duration_s: float) -> np.ndarray:
    ground = lay_ground(load_scenario(folder))
    with SumoSession(ground.options, ground.hd_map.lane_index, lambda departure: True) as session:
        recording = record_traffic(session, duration_s)
    step_s = float(recording.step_s[0])
    return np.concatenate([final_errors_m(journey, step_s) for journey in journeys(recording)])


@pytest.mark.parametrize(("scenario", "least"), [("town", 30_000), ("sharp_turns", 5_000)])
def test_ten_seconds_with_perfect_sensors_end_within_a_tenth_of_a_metre(repository, scenario, least):
    errors = measure(repository / "scenarios" / scenario, duration_s=90.0)
    assert len(errors) > least
    assert errors.max() < 0.1
    assert np.median(errors) < 0.01
