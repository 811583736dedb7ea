"""Where the estimate is the truth, vehicles that steer by it drive as if nobody steered them: on all seven nets."""

import libsumo
import numpy as np
import pytest

from gpsec.hdmap.map import load_map
from gpsec.traffic.commands import CommandKind, Commands
from gpsec.traffic.controlled import ControlledSession
from gpsec.traffic.options import resolve_options

NETS = ("town", "highway", "sharp_turns", "slow_curve", "mountain", "suburb", "beltway")
# SUMO ends a movement across the road that it is in when it is taken over.
SETTLING_STEPS = 3


def everybody(departure):
    return True


@pytest.mark.slow
@pytest.mark.parametrize("net", NETS)
def test_steered_vehicles_keep_to_their_paths_to_the_millimetre(repository, net):
    options = resolve_options(repository / "scenarios" / net / f"{net}.sumocfg", seed=42, closed_loop=True)
    hd_map = load_map(options.net_file, (2.0,))
    steered, off_m, stood, lost = {}, [], {}, 0
    with ControlledSession(options, hd_map.lane_index, everybody) as session:
        actuation = session._actuation
        held, lanes = actuation.now, actuation.lanes.now
        for frame in session.frames(60.0):
            lost += sum("#" in departure.vehicle_id for departure in frame.departures)
            held = actuation.now
            for row in frame.left:
                steered.pop(row, None)
                stood.pop(row, None)
            for row in actuation.rows.tolist():
                steered[row] = steered.get(row, 0) + 1
                name = actuation.name_of(row)
                lane, path = session._lane[row], held.path[row]
                if steered[row] > SETTLING_STEPS and lanes.edge[lane] == lanes.edge[path]:
                    put = libsumo.vehicle.getLateralLanePosition(name) + lanes.middle_m[lane] - lanes.middle_m[path]
                    off_m.append(put - held.shadow_m[row])  # the surplus makes up for what is between it and the path
            assert np.abs(frame.carried.surplus_m).max(initial=0.0) < 2.0
            count = len(frame.rows)
            order = np.full(count, CommandKind.STEER, np.int32)
            session.command(Commands(frame.rows, np.zeros(count, np.bool_), order, np.zeros(count), np.zeros(count)))
    assert len(off_m) > 2000
    assert np.abs(off_m).max() <= 0.001 + 1e-9
    assert frame.carried.teleports == 0
    assert lost == 0
