"""Tapes: played back, they have the spread, the spectrum and the gaps that were recorded."""

from dataclasses import replace
from math import floor

import numpy as np
import pytest

from gpsec.core.errors import GpsecError
from gpsec.core.noise import CAMERA_TAPE, GNSS_TAPE, plain_uniform
from gpsec.core.threads import Threads
from gpsec.sensors.sense_kernels import CONSTANT
from gpsec.sensors.tape_loop import make_loop
from gpsec.sensors.tapes import Tapes, check_tape, samples_per_step
from gpsec.testing.drive import Drive
from gpsec.types.tapes import Tape
from tests.sensors.exact import profile

RATE_HZ = 20.0
TAU_S = 0.6


def recorded(
    kind: str = "camera", pieces: int = 40, piece_s: float = 30.0, rate_hz: float = RATE_HZ, seed: int = 1
) -> Tape:
    """A Gauss-Markov error of 0.1 m and 0.6 s in pieces, a tenth of it lost in gaps of half a second."""
    generator = np.random.default_rng(seed)
    columns = 4 if kind == "camera" else 2
    length = int(piece_s * rate_hz)
    decay = np.exp(-1.0 / (rate_hz * TAU_S))
    errors = np.zeros((pieces * length, columns))
    kicks = generator.standard_normal(errors.shape) * 0.1
    for at in range(len(errors)):
        fresh = at % length == 0
        errors[at] = kicks[at] if fresh else decay * errors[at - 1] + np.sqrt(1.0 - decay**2) * kicks[at]
    missing = np.zeros(len(errors), np.bool_)
    gap = int(0.5 * rate_hz)
    for begin in generator.choice(len(errors) - gap, int(0.1 * len(errors) / gap), replace=False):
        missing[begin : begin + gap] = True
    errors[missing] = 0.0
    piece = np.arange(0, len(errors), length)
    sigma = np.where(missing, 0.0, 0.12)
    return Tape(
        kind, rate_hz, errors, missing, sigma, piece, np.zeros((pieces, columns)), "made", {"made_by": "a test"}
    )


def played(tape: Tape, vehicles: int = 60, steps: int = 1200, **drive) -> tuple[np.ndarray, np.ndarray]:
    """Return (S, N, K) errors of standing vehicles with exact sensors but for the tape, and (S, N) what is there."""
    tapes = Tapes(camera=tape) if tape.kind == "camera" else Tapes(gnss=tape)
    fleet = Drive((profile(camera={"rate_hz": 20.0}, gnss={"rate_hz": 20.0}),), vehicles, tapes=tapes, **drive)
    errors, there = [], []
    for _ in range(steps):
        seen = fleet.sense()
        camera = tape.kind == "camera"
        errors.append((seen.lane_poly if camera else seen.fix_m).copy())
        there.append((seen.camera_valid if camera else seen.fix_valid).copy())
    return np.array(errors), np.array(there)


def correlation(values: np.ndarray, there: np.ndarray, lag: int) -> float:
    """Return the autocorrelation at a lag, along the first axis."""
    both = there[lag:] & there[:-lag]
    one, other = values[lag:][both], values[:-lag][both]
    return float(np.corrcoef(one, other)[0, 1])


@pytest.mark.parametrize("kind", ["camera", "gnss"])
def test_played_back_a_tape_is_what_was_recorded(kind):
    """Standard deviation ± 3 %, autocorrelation at 0.1, 0.5 and 1 s ± 0.03, gaps ± 10 %."""
    tape = recorded(kind)
    errors, there = played(tape)
    of_tape = tape.errors[:, 0], ~tape.missing
    assert errors[..., 0][there].std() == pytest.approx(of_tape[0][of_tape[1]].std(), rel=0.03)
    for lag_s in (0.1, 0.5, 1.0):
        recorded_one = correlation(*of_tape, round(lag_s * RATE_HZ))
        assert correlation(errors[..., 0], there, round(lag_s * 10.0)) == pytest.approx(recorded_one, abs=0.03)
        assert recorded_one == pytest.approx(np.exp(-lag_s / TAU_S), abs=0.05)
    assert 1.0 - there.mean() == pytest.approx(tape.missing.mean(), rel=0.1)


@pytest.mark.parametrize("kind", ["camera", "gnss"])
def test_every_sample_is_that_of_the_loop(kind):
    """The plain formula: tape[(hash(key)·L + step·rate·dt) mod L]."""
    tape = recorded(kind, pieces=3, piece_s=5.0)
    loop = make_loop(tape)
    errors, there = played(tape, vehicles=5, steps=60)
    keys = Drive((profile(),), 5).vehicles.key.tolist()
    channel = CAMERA_TAPE if kind == "camera" else GNSS_TAPE
    for vehicle, key in enumerate(keys):
        begin = plain_uniform(key, channel, CONSTANT) * len(loop.missing)
        for step in range(60):
            at = floor(begin + step * 2.0) % len(loop.missing)
            assert there[step, vehicle] == (not loop.missing[at])
            if there[step, vehicle]:
                assert errors[step, vehicle].tolist() == loop.errors[at].tolist()


def test_the_same_bits_for_two_threads(monkeypatch):
    monkeypatch.setattr(Threads, "MIN_ROWS", 4)
    tape = recorded(pieces=4)
    found = []
    for count in (1, 2):
        fleet, threads = Drive((profile(),), 40, tapes=Tapes(camera=tape)), Threads(count)
        found.append([[array.tobytes() for array in fleet.sense(threads=threads)] for _ in range(30)])
        threads.close()
    assert found[0] == found[1]


def test_a_loop_has_no_seam():
    """Two constant pieces, +1 and -1: at no step does the error change by more than a fade allows."""
    piece = np.array([0, 100])
    errors = np.repeat([1.0, -1.0], 100)[:, None] * np.ones((1, 2))
    tape = Tape("gnss", 20.0, errors, np.zeros(200, np.bool_), np.ones(200), piece, np.zeros((2, 2)), "made", {})
    loop = make_loop(tape)
    fade = 25  # a quarter of a piece, since 20 s do not fit
    assert len(loop.missing) == 200 - 2 * fade
    around = np.concatenate([loop.errors, loop.errors[:1]])[:, 0]
    # cos θ - sin θ changes by √2·π/2 over the whole fade at most.
    assert np.abs(np.diff(around)).max() <= np.sqrt(2.0) * np.pi / 2.0 / fade + 1e-9
    assert loop.sigma_m == pytest.approx(1.0)


def test_a_fade_into_a_gap_keeps_the_heavier_side():
    missing = np.zeros(192, np.bool_)
    missing[96:120] = True  # the beginning of the second piece
    errors = np.where(missing[:, None], 0.0, 1.0) * np.ones((1, 2))
    tape = Tape("gnss", 20.0, errors, missing, np.ones(192), np.array([0, 96]), np.zeros((2, 2)), "made", {})
    loop = make_loop(tape)
    fade = slice(48, 72)
    assert loop.missing[fade].tolist() == [False] * 12 + [True] * 12
    assert loop.errors[fade][:12].tolist() == [[1.0, 1.0]] * 12


def test_a_receivers_offset_stays_and_its_white_noise_goes():
    tape = recorded("gnss", pieces=2)
    still = replace(tape, errors=np.zeros_like(tape.errors), missing=np.zeros_like(tape.missing))
    one = profile(
        gnss={"white_m": 1.0, "bias_m": 2.0, "bias_tau_s": 1.0, "outages_per_h": 3600.0, "outage_mean_s": 5.0}
    )
    fleet = Drive((one,), 400, tapes=Tapes(gnss=still))
    first = fleet.sense().fix_m.copy()
    for _ in range(50):
        seen = fleet.sense()
        assert seen.fix_valid.all()
    assert (seen.fix_m == first).all()
    assert first.std() == pytest.approx(2.0, rel=0.1)


def test_a_cameras_mounting_stays_and_its_stated_sigma_is_the_tapes():
    tape = recorded(pieces=2)
    still = replace(
        tape,
        errors=np.zeros_like(tape.errors),
        missing=np.zeros_like(tape.missing),
        sigma_m=np.full(len(tape.missing), 0.07),
    )
    one = profile(camera={"white_m": 0.5, "bias_m": 0.5, "mount_m": 0.04, "trust_limit_m": 0.3})
    seen = Drive((one,), 400, tapes=Tapes(camera=still)).sense()
    assert seen.lane_poly[:, 0].std() == pytest.approx(0.04, rel=0.1)
    assert seen.camera_sigma_m == pytest.approx(0.07)


def test_what_the_tape_states_beyond_trust_is_not_seen():
    tape = recorded(pieces=2)
    doubtful = replace(tape, sigma_m=np.where(tape.missing, 0.0, 0.5))
    seen = Drive((profile(camera={"trust_limit_m": 0.3}),), 40, tapes=Tapes(camera=doubtful)).sense()
    assert not seen.camera_valid.any()


def test_a_tape_of_another_kind_or_rate_is_refused():
    tape = recorded(pieces=2, piece_s=5.0)
    with pytest.raises(GpsecError, match=r"^t: expected a tape of kind 'gnss', found one of kind 'camera'$"):
        check_tape(tape, "t", "gnss", [profile()], 0.1)
    slow = replace(tape, rate_hz=5.0)
    with pytest.raises(GpsecError, match=r"^t: rate_hz: expected 10 or more, at which profile 'exact' .* found 5$"):
        check_tape(slow, "t", "camera", [profile(camera={"rate_hz": 20.0})], 0.1)
    check_tape(slow, "t", "camera", [profile(camera={"rate_hz": 5.0})], 0.1)


def test_samples_per_step_are_whole_where_they_should_be():
    tape = recorded(pieces=2, piece_s=5.0)
    assert samples_per_step(tape, 0.1) == 2.0
    assert samples_per_step(replace(tape, rate_hz=30.0), 0.1) == 3.0
    assert samples_per_step(replace(tape, rate_hz=12.5), 0.1) == pytest.approx(1.25)
