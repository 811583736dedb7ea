"""One car that brakes changes those near it, and nobody on the other carriageway: what makes twins causal."""

import numpy as np
import pytest

from gpsec.hdmap.map import load_map
from gpsec.traffic.commands import CommandKind, Commands
from gpsec.traffic.controlled import ControlledSession
from gpsec.traffic.options import resolve_options

WARM_STEPS, BRAKE_STEPS, STEPS = 600, 20, 1220


def everybody(departure):
    return True


def drive(options, lanes, braked):
    """Positions of all vehicles in each step after the warm-up, by id; the one called `braked` brakes for 2 s."""
    row_of, found = {}, []
    with ControlledSession(options, lanes, everybody) as session:
        for frame in session.frames(STEPS * options.step_s):
            gone = set(frame.left)
            row_of = {name: row for name, row in row_of.items() if row not in gone}
            row_of |= {departure.vehicle_id: departure.row for departure in frame.departures}
            name_of = {row: name for name, row in row_of.items()}
            if frame.step >= WARM_STEPS:
                found.append({name_of[row]: (*place, lane) for row, place, lane in zip(*_listed(frame), strict=True)})
            if braked in row_of and WARM_STEPS <= frame.step < WARM_STEPS + BRAKE_STEPS:
                rows = np.array([row_of[braked]], np.int32)
                kind, hard = np.array([CommandKind.BRAKE], np.int32), np.array([4.0])
                session.command(Commands(rows, np.zeros(1, np.bool_), kind, np.zeros(1), hard))
    return found


def _listed(frame):
    return frame.rows.tolist(), frame.front_m.tolist(), frame.lane.tolist()


@pytest.mark.slow
def test_a_car_that_brakes_changes_its_own_carriageway_alone(repository):
    options = resolve_options(repository / "scenarios" / "highway" / "highway.sumocfg", seed=42, closed_loop=True)
    hd_map = load_map(options.net_file, (2.0,))
    plain = drive(options, hd_map.lane_index, None)
    # In the middle of the road: somebody with others before and behind.
    names = sorted(plain[0], key=lambda name: plain[0][name][0])
    braked = names[len(names) // 2]
    changed = drive(options, hd_map.lane_index, braked)
    last, other = plain[-1], changed[-1]
    both = last.keys() & other.keys()
    differ = {name for name in both if last[name] != other[name]}
    assert len(both) > 150
    assert braked in differ
    course = {name: _course(plain, name) for name in both}
    against = {name for name in both if course[name] is not None and course[name] @ _course(plain, braked) < -0.5}
    assert len(against) > 30
    assert differ & against == set()
    assert len(differ) <= 0.25 * len(both)


def _course(steps, name):
    """Unit vector of the way of a vehicle over the last second that both steps have it in, None where it stands."""
    here = [step[name][:2] for step in steps[:200] if name in step]
    if len(here) < 2:
        here = [step[name][:2] for step in steps if name in step]
    way = np.array(here[-1]) - np.array(here[0])
    length = np.hypot(*way)
    return way / length if length > 1.0 else None
