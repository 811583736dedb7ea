"""The kernels of the sensors: each vehicle row by itself, every draw keyed by vehicle, channel and run step."""

from math import cos, floor, sin, sqrt, tan

import numpy as np

from gpsec.core import noise
from gpsec.core.arrays import Floats, Ints
from gpsec.core.geo import dead_reckon, wrap_angle
from gpsec.core.kernels import inline, kernel
from gpsec.core.noise import normal, uniform
from gpsec.sensors.lane_view import fit_sigmas, lane_polynomial, view_length_m
from gpsec.sensors.state import (
    CAMERA,
    EAST,
    FORWARD,
    GNSS,
    GYRO,
    HEADING,
    LEFT,
    NORTH,
    ODOMETER,
    SPEED,
    TURN,
    YAW_RATE,
    SensorState,
)
from gpsec.sensors.table import (
    BIAS,
    DECAY,
    HALF_VIEW,
    KICK,
    LATENCY,
    MOUNT,
    OUTAGE_BEGIN,
    OUTAGE_END,
    RANGE,
    TICKS,
    TRUST,
    UNKNOWN,
    WHITE,
    ProfileTable,
)
from gpsec.types.vehicles import Measurements, Vehicles

# Counters of draws that belong to no step of the run (those count from 0): what is constant for a vehicle, and what
# it enters with, which is counted from here by the step of entry.
CONSTANT = -1
ENTRY = 1 << 40


@inline
def gauss(key: np.uint64, channel: int, step: int, sigma: float) -> float:
    """Return a normal draw with that σ; no draw is made for σ = 0."""
    return sigma * normal(key, channel, step) if sigma > 0.0 else 0.0


@inline
def ticks(key: np.uint64, channel: int, step: int, per_step: float) -> bool:
    """Whether a clock of `per_step` < 1 samples a step passes a whole number in this one; its phase is the vehicle's.

    The same expression is rounded for this step and for the one before, so that no tick is lost or counted twice.
    """
    if per_step >= 1.0:
        return True
    phase = uniform(key, channel, CONSTANT)
    return floor(phase + per_step * step) > floor(phase + per_step * (step - 1))


@inline
def in_outage(out: bool, key: np.uint64, channel: int, step: int, table: Floats, p: int) -> bool:
    """Return the next state of the two-state Markov chain of outages."""
    if not out and table[p, OUTAGE_BEGIN] <= 0.0:
        return False
    draw: float = uniform(key, channel, step)
    limit: float = table[p, OUTAGE_END] if out else table[p, OUTAGE_BEGIN]
    return draw >= limit if out else draw < limit


@inline
def starts_out(key: np.uint64, channel: int, entry: int, table: Floats, p: int) -> bool:
    """Whether an outage lasts when the vehicle enters, with the chain's stationary probability."""
    begin: float = table[p, OUTAGE_BEGIN]
    end: float = table[p, OUTAGE_END]
    return begin > 0.0 and uniform(key, channel, entry) < begin / (begin + end)


@kernel
def enter_rows(rows: Ints, step: int, truth: Vehicles, table: ProfileTable, mind: SensorState) -> None:
    """Draw the biases from their stationary distributions, the constants of the vehicle, and lasting outages."""
    gnss, gyro, odometer, heading, camera = table.gnss, table.gyro, table.odometer, table.heading, table.camera
    entry = ENTRY + step
    for i in range(len(rows)):
        row = rows[i]
        key, p = truth.key[row], truth.profile[row]
        mind.gnss_bias_m[row, 0] = gauss(key, noise.GNSS_BIAS_EAST, entry, gnss[p, BIAS])
        mind.gnss_bias_m[row, 1] = gauss(key, noise.GNSS_BIAS_NORTH, entry, gnss[p, BIAS])
        mind.gyro_bias_rps[row] = gauss(key, noise.GYRO_BIAS, entry, gyro[p, BIAS])
        mind.heading_bias_rad[row] = gauss(key, noise.HEADING_BIAS, entry, heading[p, BIAS])
        mind.camera_bias_m[row] = gauss(key, noise.CAMERA_BIAS, entry, camera[p, BIAS])
        mind.odometer_scale[row] = gauss(key, noise.ODOMETER_SCALE, CONSTANT, odometer[p, BIAS])
        mind.mount_m[row] = gauss(key, noise.CAMERA_MOUNT, CONSTANT, camera[p, MOUNT])
        mind.out[row, GNSS] = starts_out(key, noise.GNSS_DROPOUT, entry, gnss, p)
        mind.out[row, GYRO] = starts_out(key, noise.GYRO_DROPOUT, entry, gyro, p)
        mind.out[row, ODOMETER] = starts_out(key, noise.ODOMETER_DROPOUT, entry, odometer, p)
        mind.out[row, HEADING] = starts_out(key, noise.HEADING_DROPOUT, entry, heading, p)
        mind.out[row, CAMERA] = starts_out(key, noise.CAMERA_DROPOUT, entry, camera, p)


@inline
def drift(rows: Ints, step: int, truth: Vehicles, table: ProfileTable, mind: SensorState) -> None:
    """Advance the Gauss-Markov biases by one step."""
    gnss, gyro, heading, camera = table.gnss, table.gyro, table.heading, table.camera
    for i in range(len(rows)):
        row = rows[i]
        key, p = truth.key[row], truth.profile[row]
        kick = gauss(key, noise.GNSS_BIAS_EAST, step, gnss[p, KICK])
        mind.gnss_bias_m[row, 0] = gnss[p, DECAY] * mind.gnss_bias_m[row, 0] + kick
        kick = gauss(key, noise.GNSS_BIAS_NORTH, step, gnss[p, KICK])
        mind.gnss_bias_m[row, 1] = gnss[p, DECAY] * mind.gnss_bias_m[row, 1] + kick
        kick = gauss(key, noise.GYRO_BIAS, step, gyro[p, KICK])
        mind.gyro_bias_rps[row] = gyro[p, DECAY] * mind.gyro_bias_rps[row] + kick
        kick = gauss(key, noise.HEADING_BIAS, step, heading[p, KICK])
        mind.heading_bias_rad[row] = heading[p, DECAY] * mind.heading_bias_rad[row] + kick
        kick = gauss(key, noise.CAMERA_BIAS, step, camera[p, KICK])
        mind.camera_bias_m[row] = camera[p, DECAY] * mind.camera_bias_m[row] + kick


@inline
def note_motion(rows: Ints, step: int, truth: Vehicles, mind: SensorState) -> None:
    """Store the true motion of this step; a vehicle that enters is taken to have moved so before."""
    slots = mind.motion.shape[1]
    for i in range(len(rows)):
        row = rows[i]
        for k in range(slots if not mind.started[row] else 1):
            slot = (step + k) % slots
            mind.motion[row, slot, SPEED] = truth.speed_mps[row]
            mind.motion[row, slot, YAW_RATE] = truth.yaw_rate_rps[row]


@inline
def moved(mind: SensorState, row: int, step: int, column: int, latency: float) -> float:
    """Return the mean of a true motion over a window as long as a step that ended `latency` steps ago."""
    slots = mind.motion.shape[1]
    whole = int(latency)
    newer: float = mind.motion[row, (step - whole) % slots, column]
    older: float = mind.motion[row, (step - whole - 1) % slots, column]
    return newer + (latency - whole) * (older - newer)


@inline
def sense_speed(rows: Ints, step: int, truth: Vehicles, odometer: Floats, mind: SensorState, out: Measurements) -> None:
    """Odometer: the mean speed over a step, late by its latency; held where there is no sample."""
    for i in range(len(rows)):
        row = rows[i]
        key, p = truth.key[row], truth.profile[row]
        first = not mind.started[row]
        mind.out[row, ODOMETER] = in_outage(mind.out[row, ODOMETER], key, noise.ODOMETER_DROPOUT, step, odometer, p)
        sampled = not mind.out[row, ODOMETER] and ticks(key, noise.ODOMETER_CLOCK, step, odometer[p, TICKS])
        if sampled or first:
            speed = moved(mind, row, step, SPEED, odometer[p, LATENCY])
            white = gauss(key, noise.ODOMETER_WHITE, step, odometer[p, WHITE])
            mind.speed_mps[row] = speed * (1.0 + mind.odometer_scale[row]) + white
        out.speed_mps[row] = mind.speed_mps[row]


@inline
def sense_yaw_rate(rows: Ints, step: int, truth: Vehicles, gyro: Floats, mind: SensorState, out: Measurements) -> None:
    """Gyro: the mean yaw rate over a step, late by its latency; held where there is no sample."""
    for i in range(len(rows)):
        row = rows[i]
        key, p = truth.key[row], truth.profile[row]
        first = not mind.started[row]
        mind.out[row, GYRO] = in_outage(mind.out[row, GYRO], key, noise.GYRO_DROPOUT, step, gyro, p)
        sampled = not mind.out[row, GYRO] and ticks(key, noise.GYRO_CLOCK, step, gyro[p, TICKS])
        if sampled or first:
            yaw_rate = moved(mind, row, step, YAW_RATE, gyro[p, LATENCY])
            white = gauss(key, noise.GYRO_WHITE, step, gyro[p, WHITE])
            mind.yaw_rate_rps[row] = yaw_rate + mind.gyro_bias_rps[row] + white
        out.yaw_rate_rps[row] = mind.yaw_rate_rps[row]


@inline
def sense_heading(
    rows: Ints, step: int, step_s: float, truth: Vehicles, heading: Floats, mind: SensorState, out: Measurements
) -> None:
    """Heading: yaw as the vehicle knows it; carried on by the gyro over its latency and where there is no sample."""
    for i in range(len(rows)):
        row = rows[i]
        key, p = truth.key[row], truth.profile[row]
        first = not mind.started[row]
        mind.out[row, HEADING] = in_outage(mind.out[row, HEADING], key, noise.HEADING_DROPOUT, step, heading, p)
        sampled = not mind.out[row, HEADING] and ticks(key, noise.HEADING_CLOCK, step, heading[p, TICKS])
        turn = mind.yaw_rate_rps[row] * step_s
        if sampled or first:
            yaw = truth.yaw_rad[row]
            error = mind.heading_bias_rad[row] + gauss(key, noise.HEADING_WHITE, step, heading[p, WHITE])
            left_over = heading[p, LATENCY]
            if not first and left_over > 0.0:
                error += min(left_over, 1.0) * (turn - wrap_angle(yaw - mind.true_yaw_rad[row]))
                back = step - 1
                left_over -= 1.0
                while left_over > 0.0:
                    error += min(left_over, 1.0) * mind.slip[row, back % mind.slip.shape[1], TURN]
                    left_over -= 1.0
                    back -= 1
            mind.heading_rad[row] = wrap_angle(yaw + error)
        else:
            mind.heading_rad[row] = wrap_angle(mind.heading_rad[row] + turn)
        out.heading_rad[row] = mind.heading_rad[row]


@inline
def note_slip(rows: Ints, step: int, step_s: float, truth: Vehicles, mind: SensorState) -> None:
    """Store by how much the measured motion of this step differs from the true one."""
    slot = step % mind.slip.shape[1]
    for i in range(len(rows)):
        row = rows[i]
        x, y, yaw = truth.rear_m[row, 0], truth.rear_m[row, 1], truth.yaw_rad[row]
        if mind.started[row]:
            east, north = x - mind.true_rear_m[row, 0], y - mind.true_rear_m[row, 1]
            forward, left = cos(yaw) * east + sin(yaw) * north, cos(yaw) * north - sin(yaw) * east
            distance, turn = mind.speed_mps[row] * step_s, mind.yaw_rate_rps[row] * step_s
            moved_x, moved_y = dead_reckon(0.0, 0.0, mind.heading_rad[row] - turn, distance, turn)
            mind.slip[row, slot, EAST] = moved_x - east
            mind.slip[row, slot, NORTH] = moved_y - north
            # In the frame at the step's end, which the vehicle believes to have turned by `turned` too much.
            turned = turn - wrap_angle(yaw - mind.true_yaw_rad[row])
            moved_x, moved_y = dead_reckon(0.0, 0.0, -turn, distance, turn)
            mind.slip[row, slot, FORWARD] = moved_x - forward
            mind.slip[row, slot, LEFT] = moved_y - left + turned * forward
            mind.slip[row, slot, TURN] = turned
        mind.true_rear_m[row, 0], mind.true_rear_m[row, 1] = x, y
        mind.true_yaw_rad[row] = yaw


@inline
def sense_fix(rows: Ints, step: int, truth: Vehicles, gnss: Floats, mind: SensorState, out: Measurements) -> None:
    """GNSS fix of the rear axle, carried on over its latency by odometer, gyro and heading."""
    slots = mind.slip.shape[1]
    for i in range(len(rows)):
        row = rows[i]
        key, p = truth.key[row], truth.profile[row]
        mind.out[row, GNSS] = in_outage(mind.out[row, GNSS], key, noise.GNSS_DROPOUT, step, gnss, p)
        valid = not mind.out[row, GNSS] and ticks(key, noise.GNSS_CLOCK, step, gnss[p, TICKS])
        out.fix_valid[row] = valid
        if not valid:
            continue
        east, north = mind.gnss_bias_m[row, 0], mind.gnss_bias_m[row, 1]
        left_over = gnss[p, LATENCY]
        back = step
        while left_over > 0.0:
            weight = min(left_over, 1.0)
            east += weight * mind.slip[row, back % slots, EAST]
            north += weight * mind.slip[row, back % slots, NORTH]
            left_over -= 1.0
            back -= 1
        east += gauss(key, noise.GNSS_WHITE_EAST, step, gnss[p, WHITE])
        north += gauss(key, noise.GNSS_WHITE_NORTH, step, gnss[p, WHITE])
        out.fix_m[row, 0] = truth.rear_m[row, 0] + east
        out.fix_m[row, 1] = truth.rear_m[row, 1] + north


@inline
def sense_lane(
    rows: Ints, step: int, step_s: float, truth: Vehicles, camera: Floats, mind: SensorState, out: Measurements
) -> None:
    """Lane polynomial, carried on over its latency by odometer and gyro."""
    slots = mind.slip.shape[1]
    for i in range(len(rows)):
        row = rows[i]
        key, p = truth.key[row], truth.profile[row]
        mind.out[row, CAMERA] = in_outage(mind.out[row, CAMERA], key, noise.CAMERA_DROPOUT, step, camera, p)
        sampled = not mind.out[row, CAMERA] and ticks(key, noise.CAMERA_CLOCK, step, camera[p, TICKS])
        lane_turn = wrap_angle(truth.camera_yaw_rad[row] - truth.yaw_rad[row])
        curvature = truth.camera_curvature_per_m[row]
        view = view_length_m(camera[p, RANGE], camera[p, HALF_VIEW], curvature)
        s0, s1, s2, s3 = fit_sigmas(camera[p, WHITE], camera[p, RANGE], view)
        stated = sqrt(s0 * s0 + camera[p, BIAS] * camera[p, BIAS] + camera[p, MOUNT] * camera[p, MOUNT])
        valid = sampled and truth.marked[row] and cos(lane_turn) >= 0.5 and stated <= camera[p, TRUST]
        out.camera_valid[row] = valid
        if not valid:
            continue
        forward, left, turned, driven = 0.0, 0.0, 0.0, 0.0
        left_over = camera[p, LATENCY]
        back = step
        while left_over > 0.0:
            weight = min(left_over, 1.0)
            slot = back % slots
            forward += weight * mind.slip[row, slot, FORWARD]
            # Within a step the lateral slip grows with the square of time.
            left += weight * (weight * mind.slip[row, slot, LEFT] + mind.slip[row, slot, TURN] * driven)
            turned += weight * mind.slip[row, slot, TURN]
            driven += truth.speed_mps[row] * step_s
            left_over -= 1.0
            back -= 1
        c0, c1, c2, c3 = lane_polynomial(truth.camera_offset_m[row], lane_turn, curvature)
        unknown = camera[p, UNKNOWN]
        c0 += c1 * forward - left + unknown * mind.mount_m[row] + unknown * mind.camera_bias_m[row]
        if turned != 0.0:
            c1 = tan(lane_turn - turned)
        out.lane_poly[row, 0] = c0 + gauss(key, noise.CAMERA_C0, step, unknown * s0)
        out.lane_poly[row, 1] = c1 + gauss(key, noise.CAMERA_C1, step, unknown * s1)
        out.lane_poly[row, 2] = c2 + gauss(key, noise.CAMERA_C2, step, unknown * s2)
        out.lane_poly[row, 3] = c3 + gauss(key, noise.CAMERA_C3, step, unknown * s3)
        out.camera_sigma_m[row] = stated


@kernel
def sense_rows(
    rows: Ints, step: int, step_s: float, truth: Vehicles, table: ProfileTable, mind: SensorState, out: Measurements
) -> None:
    """Fill the measurements of `rows` for this step.

    One loop a channel: handing these tuples to a function for each row would cost more than the channel itself.
    """
    for i in range(len(rows)):
        row = rows[i]
        if not mind.started[row]:
            out.fix_m[row, 0], out.fix_m[row, 1] = 0.0, 0.0
            for k in range(4):
                out.lane_poly[row, k] = 0.0
            out.camera_sigma_m[row] = 0.0
    drift(rows, step, truth, table, mind)
    note_motion(rows, step, truth, mind)
    sense_speed(rows, step, truth, table.odometer, mind, out)
    sense_yaw_rate(rows, step, truth, table.gyro, mind, out)
    sense_heading(rows, step, step_s, truth, table.heading, mind, out)
    note_slip(rows, step, step_s, truth, mind)
    sense_fix(rows, step, truth, table.gnss, mind, out)
    sense_lane(rows, step, step_s, truth, table.camera, mind, out)
    for i in range(len(rows)):
        mind.started[rows[i]] = True
