import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpsec.core import noise

N = 200_000
KEYS = np.array([noise.vehicle_key(1, f"v{i}") for i in range(1000)], np.uint64)


def matrix(draw, channel: int = 3, steps: int = 200) -> np.ndarray:
    """(steps, 1000) draws."""
    return np.stack([draw(KEYS, channel, step) for step in range(steps)])


def splitmix(word: int) -> int:
    """The published finaliser, in Python's own integers."""
    word = ((word ^ (word >> 30)) * 0xBF58476D1CE4E5B9) % 2**64
    word = ((word ^ (word >> 27)) * 0x94D049BB133111EB) % 2**64
    return word ^ (word >> 31)


@given(st.integers(0, 2**64 - 1), st.integers(0, 100), st.integers(0, 10**7))
def test_uniform_is_splitmix_of_key_channel_and_step(key, channel, step):
    gamma = 0x9E3779B97F4A7C15
    word = splitmix((splitmix((key + gamma * (channel + 1)) % 2**64) + gamma * (step + 1)) % 2**64)
    assert noise.uniform(np.uint64(key), channel, step) == ((word >> 11) + 0.5) / 2**53


@given(st.integers(0, 2**64 - 1), st.integers(0, 100), st.integers(0, 10**7))
def test_plain_draw_is_that_of_the_kernels(key, channel, step):
    assert noise.plain_uniform(key, channel, step) == noise.uniform(np.uint64(key), channel, step)


def test_finaliser_meets_the_published_sequence():
    # The first outputs of SplitMix64 (Vigna's splitmix64.c) with seed 0 are the finalised multiples of its gamma.
    expected = [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]
    assert [splitmix((i * 0x9E3779B97F4A7C15) % 2**64) for i in (1, 2, 3)] == expected
    assert [int(noise.mix(np.uint64((i * 0x9E3779B97F4A7C15) % 2**64))) for i in (1, 2, 3)] == expected


def test_normal_moments():
    draws = matrix(noise.normals).ravel()
    # Standard errors of the moments of N standard normal draws; 4 of them.
    for power, expected, spread in ((1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)):
        assert abs((draws**power).mean() - expected) < 4.0 * np.sqrt(spread / N)
    assert np.isfinite(draws).all()
    assert 4.0 < abs(draws).max() < 6.5


def test_uniform_moments():
    draws = matrix(noise.uniforms).ravel()
    assert 0.0 < draws.min() < draws.max() < 1.0
    counts = np.bincount((draws * 20).astype(int), minlength=20)
    assert (((counts - N / 20) ** 2) / (N / 20)).sum() < 43.8  # chi-square of 19 degrees of freedom, 0.1 %


def test_independent_over_keys_steps_and_channels():
    draws = matrix(noise.normals)
    others = (
        ("step", draws[1:], draws[:-1]),
        ("key", draws[:, 1:], draws[:, :-1]),
        ("channel", draws, matrix(noise.normals, channel=4)),
        ("seed", draws, np.stack([noise.normals(KEYS + np.uint64(1), 3, step) for step in range(200)])),
    )
    for name, one, other in others:
        assert abs((one * other).mean()) < 4.0 / np.sqrt(one.size), name
        assert abs((one**2 * other**2).mean() - 1.0) < 4.0 * np.sqrt(8.0 / one.size), name


@pytest.mark.parametrize("draw", [noise.uniforms, noise.normals])
def test_a_draw_does_not_depend_on_its_batch(draw):
    whole = draw(KEYS, 7, 12)
    order = np.random.default_rng(1).permutation(len(KEYS))[:321]
    assert draw(KEYS[order], 7, 12).tobytes() == whole[order].tobytes()
    assert draw(KEYS[5:6], 7, 12)[0] == whole[5]


def test_every_channel_has_a_number_of_its_own():
    channels = [value for name, value in vars(noise).items() if name.isupper() and not name.startswith("_")]
    assert len(channels) > 30
    assert len(set(channels)) == len(channels)


def test_keys_do_not_depend_on_the_process():
    code = "from gpsec.core.noise import vehicle_key; print(vehicle_key(7, 'flow.3'), vehicle_key(7, 'Ärger#2'))"
    for hash_seed in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-c", code], env={"PYTHONHASHSEED": hash_seed}, capture_output=True, text=True, check=True
        )
        expected = [noise.vehicle_key(7, "flow.3"), noise.vehicle_key(7, "Ärger#2")]
        assert [int(word) for word in done.stdout.split()] == expected


def test_keys_differ_between_seeds_and_vehicles():
    keys = {noise.vehicle_key(seed, f"v{i}") for seed in range(20) for i in range(500)}
    assert len(keys) == 20 * 500
    assert all(0 <= key < 2**64 for key in keys)
