import numpy as np
import pytest

from gpsec.outcomes.bands import BANDS_PER_OCTAVE, ERROR_BINS, SECONDS, error_bin, error_edges, quantile, stride
from gpsec.outcomes.tables import read_table

from .scene import Scene


def test_edges_and_bins_agree():
    edges = error_edges()
    assert edges[1] == 2.0**-8
    for place in (1, 2, 100, ERROR_BINS - 2, ERROR_BINS - 1):
        assert error_bin(edges[place]) == place
        assert error_bin(np.nextafter(edges[place], 0.0)) == place - 1


@pytest.mark.parametrize("share", [0.05, 0.5, 0.95])
def test_quantiles_are_those_of_numpy_within_a_bin(share):
    errors = np.random.default_rng(2).exponential(0.7, 4000)
    counts = np.bincount([error_bin(error) for error in errors], minlength=ERROR_BINS)[None, :]
    assert quantile(counts, share)[0] == pytest.approx(np.quantile(errors, share), rel=1.0 / BANDS_PER_OCTAVE)


def test_a_stride_is_about_a_second():
    assert [stride(step_s) for step_s in (0.1, 0.05, 0.2, 0.15, 2.0)] == [10, 20, 5, 7, 1]


def test_a_vehicle_counts_once_a_second_of_its_attack(tmp_path):
    scene = Scene(capacity=4)
    for step in range(40):
        if step == 5:
            scene.fork(0, 2, 1, step)
            scene.fork(1, 3, 1, step)
        if step == 20:
            scene.end_attack(3, step)
        # East is along the lane: 0.5 m ahead, and 2 m or 4 m to the right of the truth.
        scene.estimate_m[2:, 0] = [0.5, -2.0], [0.5, -4.0]
        scene.observe(step, [0, 1, 2, 3] if step >= 5 else [0, 1])
    for row, name in enumerate("abab"):
        scene.close(row, name)
    scene.outcomes.write(tmp_path, "lane", 1, replicates=5)
    table = read_table(tmp_path, "error_bands")
    mine = table[table["defence"] == "cusum+ukf"]
    assert mine["time_s"].tolist() == [0.0, 1.0, 2.0, 3.0]  # steps 5, 15, 25, 35
    assert mine["n_vehicles"].tolist() == [2, 2, 1, 1]
    alone = mine[mine["n_vehicles"] == 1]
    assert alone["cross_track_median_m"].to_numpy() == pytest.approx([2.0, 2.0], rel=1.0 / BANDS_PER_OCTAVE)
    assert mine["cross_track_p95_m"].iloc[0] == pytest.approx(4.0, rel=1.0 / BANDS_PER_OCTAVE)
    assert mine["along_track_median_m"].to_numpy() == pytest.approx([0.5] * 4, rel=1.0 / BANDS_PER_OCTAVE)


def test_attacks_are_followed_two_minutes(tmp_path):
    scene = Scene(capacity=2, step_s=1.0)
    for step in range(SECONDS + 10):
        if step == 1:
            scene.fork(0, 1, 1, step)
        scene.observe(step, [0, 1] if step >= 1 else [0])
    scene.close(1, "a")
    scene.outcomes.write(tmp_path, "lane", 1, replicates=5)
    assert read_table(tmp_path, "error_bands")["time_s"].max() == SECONDS
