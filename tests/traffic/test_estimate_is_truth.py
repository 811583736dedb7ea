"""Where the estimate is the truth, vehicles that steer by it drive as if nobody steered them."""

import libsumo
import numpy as np
import pytest

from gpsec.hdmap.map import load_map
from gpsec.traffic.commands import CommandKind, Commands
from gpsec.traffic.controlled import ControlledSession
from gpsec.traffic.options import resolve_options

from .driven import CAR, Driven, everybody, steer

NETS = ("town", "highway", "sharp_turns", "slow_curve", "mountain", "suburb", "beltway")
# SUMO ends a movement across the road that it is in when it is taken over.
SETTLING_STEPS = 3
FLOWS = (
    CAR
    + '<flow id="f" type="car" begin="0" end="40" period="2" departLane="free" from="A0B0" to="B2C2"/>'
    + '<flow id="g" type="car" begin="0" end="40" period="3" departLane="free" from="C2B2" to="B0A0"/>'
)


class Settled:
    """How far steered vehicles are from the middle of their paths, once SUMO has ended what it was in."""

    def __init__(self):
        self.steps, self.off_m = {}, []

    def see(self, session, frame):
        actuation, lane_of = session._actuation, session._lane
        held, lanes = actuation.now, actuation.lanes.now
        for row in frame.left:
            self.steps.pop(row, None)
        for row, surplus_m in zip(actuation.rows.tolist(), frame.carried.surplus_m.tolist(), strict=True):
            self.steps[row] = self.steps.get(row, 0) + 1
            lane, path = lane_of[row], held.path[row]
            if self.steps[row] > SETTLING_STEPS and lanes.edge[lane] == lanes.edge[path]:
                sumo_m = libsumo.vehicle.getLateralLanePosition(actuation.name_of(row))
                place_m = sumo_m + lanes.middle_m[lane] - lanes.middle_m[path] + lanes.left_sign[0] * surplus_m
                self.off_m.append(place_m - held.shift_m[row])  # a path that goes over to another lane is on its way


def all_steered_to_the_middle(rows):
    count = len(rows)
    order = np.full(count, CommandKind.STEER, np.int32)
    return Commands(rows, np.zeros(count, np.bool_), order, np.zeros(count), np.zeros(count))


def check(config, lane_index, seconds, least_steps):
    """Let everybody be steered, and nobody leave their path, be hit, or be lost."""
    settled, departed, arrived, lost = Settled(), 0, 0, 0
    options = resolve_options(config, seed=42, closed_loop=True)
    with ControlledSession(options, lane_index, everybody) as session:
        for frame in session.frames(seconds):
            lost += sum("#" in departure.vehicle_id for departure in frame.departures)
            departed += len(frame.departures)
            arrived += len(frame.left)
            settled.see(session, frame)
            assert not libsumo.simulation.getCollisions()
            assert np.abs(frame.carried.surplus_m).max(initial=0.0) < 2.0
            session.command(all_steered_to_the_middle(frame.rows))
    assert len(settled.off_m) > least_steps
    assert np.abs(settled.off_m).max() <= 0.001 + 1e-9
    assert departed == arrived + len(frame.rows)
    assert frame.carried.removed == frame.carried.teleports == lost == 0
    return arrived


@pytest.mark.slow
@pytest.mark.parametrize("net", NETS)
def test_steered_vehicles_keep_to_their_paths_to_the_millimetre(repository, net):
    config = repository / "scenarios" / net / f"{net}.sumocfg"
    check(config, load_map(resolve_options(config, seed=42).net_file, (2.0,)).lane_index, 60.0, 2000)


def test_so_they_do_on_a_grid(scenario, lane_index):
    check(scenario(FLOWS), lane_index, 50.0, 2000)


def test_who_departed_has_arrived_was_removed_or_is_on_the_road(scenario, lane_index):
    """By SUMO's own count: a steered wreck is taken out, others stand behind another one when the time is over."""
    departed, arrived = 0, 0
    with Driven(scenario(FLOWS), lane_index) as driven:
        for frame in driven.frames(60.0):
            departed += libsumo.simulation.getDepartedNumber()
            arrived += libsumo.simulation.getArrivedNumber()
            if frame.step == 150:
                driven.session.command(steer([driven.row["f.1"]], order=CommandKind.REMOVE))
            elif frame.step > 200:
                driven.steer("f.4", 0.0, 8.0)
            else:
                driven.steer("f.1", 0.0, 8.0 if frame.step > 100 else 0.0)
    assert frame.carried.removed == 1
    assert len(driven.place) == frame.on_road > 5
    assert arrived > 0
    assert departed == arrived + frame.carried.removed + frame.on_road
