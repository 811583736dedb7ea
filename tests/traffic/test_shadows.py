"""The kernels of steered vehicles against their plain twin, for vehicles and lanes at random."""

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.reference.shadow import PlainLane, PlainShadow
from gpsec.traffic.commands import CommandKind
from gpsec.traffic.shadows import Held, Orders, Placed, TakenOver, move_shadows, settle_shadows, take_orders
from gpsec.traffic.sumo_lanes import LaneArrays, _line

STEP_S, VEHICLES, EDGES = 0.1, 60, 6


def some_lanes(rng):
    """Six edges of one to three lanes whose shapes bend, two of them within junctions."""
    lanes = []
    for edge in range(EDGES):
        count = int(rng.integers(1, 4))
        width, length = float(rng.uniform(2.8, 3.6)), float(rng.uniform(20.0, 150.0))
        for at in range(count):
            turn = np.cumsum(rng.uniform(-0.4, 0.4, 5)) + rng.uniform(-3.0, 3.0)
            points = np.cumsum(np.stack([np.cos(turn), np.sin(turn)], axis=1) * length / 5.0, axis=0)
            shape = tuple(map(tuple, points.tolist()))
            middle = width * (at + 0.5)
            lanes.append(PlainLane(edge, edge < 2, middle, width, length, at < count - 1, at > 0, at, shape))
    return lanes


def as_arrays(lanes, left_sign):
    lines = [_line(lane.points_m) for lane in lanes]
    numbers = np.arange(len(lanes))
    return LaneArrays(
        left_sign=np.array([left_sign]),
        edge=np.array([lane.edge for lane in lanes], np.int32),
        internal=np.array([lane.internal for lane in lanes]),
        middle_m=np.array([lane.middle_m for lane in lanes]),
        width_m=np.array([lane.width_m for lane in lanes]),
        length_m=np.array([lane.length_m for lane in lanes]),
        left=np.where([lane.has_left for lane in lanes], numbers + 1, -1).astype(np.int32),
        right=np.where([lane.has_right for lane in lanes], numbers - 1, -1).astype(np.int32),
        first=np.cumsum([0, *(len(at) for at, _ in lines)], dtype=np.int32),
        at_m=np.concatenate([at for at, _ in lines]),
        yaw_rad=np.concatenate([yaw for _, yaw in lines]),
        stretch=np.array([at[-1] for at, _ in lines]) / np.array([lane.length_m for lane in lanes]),
    )


def beside(rng, lanes, lane):
    return int(rng.choice([k for k, other in enumerate(lanes) if other.edge == lanes[lane].edge]))


@pytest.mark.parametrize("left_sign", [1.0, -1.0])
def test_shadows_move_as_their_plain_twin_does(left_sign):
    rng = np.random.default_rng(3)
    lanes = some_lanes(rng)
    arrays = as_arrays(lanes, left_sign)
    held, rows = Table(Held, 2 * VEHICLES).now, np.arange(1, 2 * VEHICLES, 2, dtype=np.int32)
    held.lane[rows] = rng.integers(0, len(lanes), VEHICLES)
    held.path[rows] = [beside(rng, lanes, lane) for lane in held.lane[rows]]
    for field in (held.shift_m, held.wish_m, held.shadow_m):
        field[rows] = rng.normal(0.0, 2.0, VEHICLES)
    held.half_width_m[rows] = rng.uniform(0.8, 1.8, VEHICLES)
    held.position_m[rows] = rng.uniform(0.0, 60.0, VEHICLES)
    held.speed_mps[rows] = rng.uniform(-1.0, 25.0, VEHICLES)
    across = (held.shift_m, held.wish_m, held.shadow_m, held.half_width_m, held.position_m, held.speed_mps)
    plain = [
        PlainShadow(lanes[held.path[row]], lanes[held.lane[row]], *(float(field[row]) for field in across))
        for row in rows
    ]
    lane, placed = held.lane.copy(), Placed.room(VEHICLES + 3)
    for _ in range(40):
        onwards = rng.random(VEHICLES) < 0.1
        lane[rows[onwards]] = rng.integers(0, len(lanes), onwards.sum())
        held.wish_m[rows] += rng.normal(0.0, 0.2, VEHICLES)
        for one, row in zip(plain, rows, strict=True):
            one.wish_m = float(held.wish_m[row])
        move_shadows(rows, lane, arrays, STEP_S, held, placed)
        put = np.array([one.place(lanes[lane[row]], STEP_S) for one, row in zip(plain, rows, strict=True)])
        np.testing.assert_allclose(placed.put_m[:VEHICLES], put[:, 0], atol=1e-12)
        np.testing.assert_allclose(placed.nudge_m[:VEHICLES], put[:, 1], atol=1e-15)
        changed = rng.random(VEHICLES) < 0.1  # SUMO changes the lane in the step
        lane[rows[changed]] = [beside(rng, lanes, at) for at in lane[rows[changed]]]
        position = held.position_m[rows] + rng.uniform(0.0, 2.0, VEHICLES)
        settle_shadows(rows, lane, position, arrays, STEP_S, held, placed)
        off = np.array(
            [
                one.settle(lanes[lane[row]], at, STEP_S, left_sign)
                for one, row, at in zip(plain, rows, position.tolist(), strict=True)
            ]
        )
        np.testing.assert_allclose(placed.surplus_m[:VEHICLES], off[:, 0], atol=1e-12)
        np.testing.assert_allclose(placed.apart_m[:VEHICLES], off[:, 1:], atol=1e-6)
    assert np.abs(off[:, 0]).max() > 1.0
    assert not held.shadow_m[0::2].any()


def test_orders_are_for_those_of_the_fleet_who_are_there():
    """Rows: 0 steered and steered on, 1 steered and released, 2 taken, 3 brakes, 4 has left; 9 was never there."""
    held = Table(Held, 5).now
    held.present[:4] = True
    held.held[:2] = True
    held.brake_mps2[:] = 7.0
    kind = CommandKind
    said = [
        (0, False, kind.STEER, 0.5, 1.0),
        (1, False, kind.RELEASE, 0.0, 0.0),
        (2, False, kind.STEER, -0.25, 0.0),
        (3, False, kind.BRAKE, 0.0, 3.0),
        (4, False, kind.STEER, 0.5, 2.0),
        (9, False, kind.STEER, 0.5, 2.0),
        (3, True, kind.BRAKE, 0.0, 9.0),
        (0, False, kind.REMOVE, 0.0, 0.0),
    ]
    rows, others, order, lateral, brake = (np.array(column) for column in zip(*said, strict=True))
    changes = TakenOver.room(8)
    orders = Orders(rows.astype(np.int32), others, order.astype(np.int32), lateral, brake)
    take_orders(orders, -1.0, held, changes)
    assert changes.sizes.tolist() == [1, 1, 2]
    assert (changes.begun[0], changes.ended[0]) == (2, 1)
    assert held.brake_mps2.tolist() == [1.0, 0.0, 0.0, 3.0, 0.0]
    assert held.wish_m.tolist() == [-0.5, 0.0, 0.25, 0.0, 0.0]
