"""What is kept for traces: the steps of the log, thinned, and the attacks that were asked for."""

import numpy as np
import pandas as pd
import pytest

from gpsec.core.geo import Projector
from gpsec.outcomes import samples
from gpsec.outcomes.kept_traces import MEDIAN_WINDOW, Candidates, Trace
from gpsec.outcomes.steps import StepLog

from .scene import DEFENCES, DETECTORS, PLANS, Scene

BENIGN, ATTACKED = 0, 1
# Those that are carried on to the next sample, as they are named in the log.
HELD = ["fix_x_m", "fix_y_m", "camera_offset_m", "residual_m", "cusum_statistic", "never_statistic"]


def log_at(path):
    return StepLog(path, PLANS, DETECTORS, DEFENCES, ["e_0"], Projector("!"))


def drive(folder, steps, attack, seed=3):
    """Return the log of all steps, and the traces, of a vehicle that is attacked between the two steps `attack`."""
    random, scene = np.random.default_rng(seed), Scene(traced=True)
    with log_at(folder / "all.parquet") as log:
        for step in range(steps):
            if step == attack[0]:
                scene.fork(BENIGN, ATTACKED, 1, step)
            if step == attack[1]:
                scene.end_attack(ATTACKED, step)
            rows = [BENIGN, ATTACKED] if step >= attack[0] else [BENIGN]
            scene.vehicles.rear_m[:] = 2.0 * step, 0.0
            scene.vehicles.lane_offset_m[:] = random.normal()
            scene.tracks.fix_m[:] = random.normal(size=2)
            scene.tracks.residual_m[:] = random.normal()
            scene.seen.lane_poly[:, 0] = random.normal()
            scene.tracks.fix_valid[:] = random.random() < 0.4
            scene.tracks.residual_valid[:] = random.random() < 0.4
            scene.seen.camera_valid[:] = random.random() < 0.4
            scene.statistic[:] = random.random()
            scene.scored[:] = random.random() < 0.4
            scene.alarm[:] = random.random() < 0.4
            scene.isolated[:] = random.random() < 0.4
            scene.estimate_m[:] = scene.vehicles.rear_m[:, None] + random.normal(size=2)
            scene.observe(step, rows)
            log.observe(scene.view(step, rows), ["a"] * len(rows), scene.seen)
    scene.close(ATTACKED, "a")
    scene.close(BENIGN, "a")
    with log_at(folder / "traces.parquet") as traces:
        scene.outcomes.write_traces(traces)
    return tuple(pd.read_parquet(folder / f"{name}.parquet") for name in ("all", "traces"))


def test_a_trace_is_the_log_at_every_other_step(tmp_path):
    log, traces = drive(tmp_path, 60, (21, 40))
    assert list(traces) == list(log)
    mine = log[(log["plan"] == "constant_bias") | (log["time_s"] < 2.15)].reset_index(drop=True)
    step = (10.0 * mine["time_s"]).round().astype(int) - 1
    pair = (step + 1) // 2
    expected = mine.groupby(pair)[HELD].last()  # the last one that is known, since the sample before
    at = mine[step % 2 == 0].set_index(pair[step % 2 == 0])
    expected = pd.concat([at.drop(columns=HELD), expected.reindex(at.index)], axis=1)
    found = traces.drop(columns=["fix_lon_deg", "fix_lat_deg"])
    pd.testing.assert_frame_equal(
        found.reset_index(drop=True), expected[list(found)].reset_index(drop=True), rtol=1e-6, atol=1e-6
    )
    assert set(found.loc[found["time_s"] < 2.15, "plan"]) == {"none"}


def test_a_long_attack_is_thinned_and_a_long_life_before_it_forgotten(tmp_path):
    log, traces = drive(tmp_path, 1500, (500, 1100))
    times = traces["time_s"].to_numpy()
    assert len(times) <= samples.SAMPLES_OF_TRACK
    assert times[0] == pytest.approx(50.1 - samples.BEFORE_S, abs=0.8)
    assert times[-1] == pytest.approx(110.1 + samples.AFTER_S, abs=0.8)
    gaps = np.diff(times)
    assert gaps.max() < 1.7 * np.median(gaps)
    known = log.set_index(["plan", "time_s"])["never+none_x_m"]
    found = traces.set_index([traces["plan"], traces["time_s"].round(6)])["never+none_x_m"]
    known.index = pd.MultiIndex.from_arrays([log["plan"], log["time_s"].round(6)])
    np.testing.assert_allclose(found, known.reindex(found.index), rtol=1e-6)


def test_tracks_beyond_the_memory_are_left_out(tmp_path, monkeypatch):
    monkeypatch.setattr(samples, "SAMPLE_BYTES", 1)
    _, traces = drive(tmp_path, 30, (10, 20))
    assert traces.empty


def told(errors, seen):
    """Return what is chosen of attacks in this order, the earliest of them last in time."""
    candidates = Candidates()
    for place, (error, detected) in enumerate(zip(errors, seen, strict=True)):
        candidates.add(error, seen=detected, trace=Trace(f"v{place:04}", 1, 10_000 - place, {}))
    return [int(trace.vehicle_id[1:]) for trace in candidates.chosen()]


@pytest.mark.parametrize("count", [1, 2, 15, MEDIAN_WINDOW, 200, 1001])
@pytest.mark.parametrize("seed", range(3))
def test_worst_median_and_first_missed(count, seed):
    random = np.random.default_rng(seed)
    errors, seen = random.permutation(count).astype(float), random.random(count) < 0.5
    seen[random.integers(count)] = False
    worst, middle, missed = told(errors, seen)
    assert errors[worst] == count - 1
    assert abs(errors[middle] - (count - 1) // 2) <= (0 if count <= MEDIAN_WINDOW else 0.05 * count)
    assert missed == np.flatnonzero(~seen).max()


def test_in_the_order_of_errors_the_window_follows_as_far_as_it_can():
    _, middle = told(np.arange(200.0), np.ones(200, bool))
    assert middle < MEDIAN_WINDOW * 2


def test_no_attack_leaves_no_trace():
    assert list(Candidates().chosen()) == []
