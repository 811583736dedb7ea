"""The contract of a sensor profile: `check_profile` holds all of it, each function of `PROFILE_CHECKS` one rule."""

from collections.abc import Callable, Sequence
from math import sqrt

import numpy as np

from gpsec.core.arrays import Flags
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.sensors.profiles import Channel, SensorProfile, residual_sigma_m
from gpsec.testing.contract import STEP_S, require
from gpsec.testing.drive import Drive
from gpsec.types.vehicles import Measurements

VEHICLES, STEPS = 24, 40
# What a fleet of this size may be off by, in a share of samples.
_TOLERANCE = 0.05
Taken = dict[str, np.ndarray]


def check_profile(profile: SensorProfile) -> None:
    """Hold a sensor profile to its contract.

    Raises:
        BrokenContractError: it breaks a rule, which is said.
    """
    for check in PROFILE_CHECKS:
        check(profile)


def snapshot(measurements: Measurements, rows: slice = slice(None)) -> Taken:
    """Return copies of the measurements of `rows`, by name."""
    return {name: array[rows].copy() for name, array in measurements._asdict().items()}


def along_a_bend(drive: Drive, step: int) -> None:
    """Move the vehicles along a bend, in and out of junctions, a little different for each of them."""
    drive.move(8.0 + 0.1 * step, 0.05)
    index = np.arange(drive.count)
    drive.vehicles.camera_yaw_rad[:] = drive.vehicles.yaw_rad + 0.01 * np.cos(index)
    drive.vehicles.camera_offset_m[:] = 0.3 * np.sin(index + 0.2 * step)
    drive.vehicles.camera_curvature_per_m[:] = 0.005
    drive.vehicles.marked[:] = ~_in_junction(drive.count, step)


def _in_junction(count: int, step: int) -> Flags:
    inside: Flags = (np.arange(count) + step) % 11 == 0
    return inside


def record(
    profiles: Sequence[SensorProfile],
    count: int = VEHICLES,
    steps: int = STEPS,
    parts: Sequence[Sequence[int]] | None = None,
    threads: Threads | None = None,
) -> list[Taken]:
    """Return the measurements of all steps, sensed in one batch, or in `parts` of the rows one after the other."""
    drive = Drive(tuple(profiles), count)
    taken = []
    for step in range(steps):
        along_a_bend(drive, step)
        for part in [range(count)] if parts is None else parts:
            drive.step = step - 1
            drive.sense(np.asarray(part, np.int32), threads)
        taken.append(snapshot(drive.measurements))
    return taken


def same(one: Sequence[Taken], other: Sequence[Taken]) -> bool:
    """Return whether two recordings are equal to the last bit."""
    pairs = zip(one, other, strict=True)
    return all(np.array_equal(array, right[name]) for left, right in pairs for name, array in left.items())


def available(channel: Channel) -> float:
    """Return the share of the time in which a channel has no outage."""
    return 1.0 / (1.0 + channel.outages_per_h * max(channel.outage_mean_s, STEP_S) / 3600.0)


def its_texts_are_for_readers(profile: SensorProfile) -> None:
    """Hold the title, and that a source says more than a word."""
    require(profile.title.strip() and "\n" not in profile.title, "the title is one line")
    for name, part in {"profile": profile, **profile.channels()}.items():
        for figure, source in part.sources.items():
            require(len(source) >= 5, f"{name}.{figure}: the source says where the figure comes from")


def measurements_are_finite_and_of_the_right_kind(profile: SensorProfile) -> None:
    """Hold shapes, types, and that nothing is NaN or infinite."""
    expected = snapshot(Table(Measurements, VEHICLES).now)
    for taken in record([profile]):
        for name, array in taken.items():
            require(array.shape == expected[name].shape, f"{name} has the shape of `Measurements`")
            require(np.isfinite(array).all(), f"{name} is finite")
        require((np.abs(taken["heading_rad"]) <= np.pi).all(), "a heading is within ±π")
        stated = taken["camera_sigma_m"][taken["camera_valid"]]
        require((stated > 0.0).all(), "the σ that the camera states is above 0")
        require((stated <= profile.camera.trust_limit_m).all(), "a lane with a larger σ than `trust_limit_m` is masked")


def as_many_samples_arrive_as_it_promises(profile: SensorProfile) -> None:
    """Hold the rates and the outages, and that no camera sees a lane in a junction."""
    vehicles = 200
    taken = record([profile], vehicles)
    fixes = min(profile.gnss.rate_hz * STEP_S, 1.0) * available(profile.gnss)
    found = float(np.mean([one["fix_valid"] for one in taken]))
    require(abs(found - fixes) < _TOLERANCE, f"a fix comes in {fixes:.0%} of the steps, not in {found:.0%}")
    unmarked = np.array([_in_junction(vehicles, step) for step in range(STEPS)])
    seen = np.array([one["camera_valid"] for one in taken])
    require(not seen[unmarked].any(), "no lane is seen where there are no markings")
    lanes = min(profile.camera.rate_hz * STEP_S, 1.0) * available(profile.camera)
    found = float(np.mean(seen[~unmarked]))
    # A range or a field of view that is too small for the bend, or a low trust limit, leaves nothing to detect with.
    require(found > 0.5 * lanes, f"a lane is seen on at least half of {lanes:.0%} of the steps, not on {found:.0%}")


def the_residual_has_the_promised_sigma(profile: SensorProfile) -> None:
    """Hold `residual_sigma_m` on a straight road, which filters and detectors rely on."""
    drive = Drive((profile,), 20_000)
    for _ in range(4):
        drive.move(15.0, 0.0)
        drive.sense()
    measured = drive.measurements
    both = measured.fix_valid & measured.camera_valid
    require(both.any(), "a fix and a lane come in the same step now and then")
    # The lane lies along the x axis: d_camera = -C0, and the map-matched offset of the fix is its y.
    residual = -measured.lane_poly[both, 0] - measured.fix_m[both, 1]
    found, promised = float(np.std(residual)), sqrt(residual_sigma_m(profile) ** 2 - profile.gnss.shared_m2)
    slack = 0.05 + 3.0 / np.sqrt(2.0 * both.sum())
    said = f"the residual's σ beside what all receivers share is {promised:.3g} m, not {found:.3g} m"
    require(abs(found - promised) < slack * promised, said)


def the_same_seed_gives_the_same_bytes(profile: SensorProfile) -> None:
    """Hold determinism."""
    require(same(record([profile]), record([profile])), "the same seed gives the same bytes")


def the_batch_equals_a_loop_of_singles(profile: SensorProfile) -> None:
    """Hold that a vehicle's measurements do not depend on its company, to the last bit."""
    alone = record([profile], parts=[[row] for row in range(VEHICLES)])
    require(same(record([profile]), alone), "a row is the same in whatever company it is computed")


PROFILE_CHECKS: tuple[Callable[[SensorProfile], None], ...] = (
    its_texts_are_for_readers,
    measurements_are_finite_and_of_the_right_kind,
    as_many_samples_arrive_as_it_promises,
    the_residual_has_the_promised_sigma,
    the_same_seed_gives_the_same_bytes,
    the_batch_equals_a_loop_of_singles,
)
