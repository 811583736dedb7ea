import numpy as np
import pytest
from pyarrow import parquet

from gpsec.core.geo import Projector
from gpsec.outcomes import parquet_log
from gpsec.outcomes.steps import StepLog

from .scene import DEFENCES, DETECTORS, PLANS, Scene

UTM = Projector("+proj=utm +zone=32 +datum=WGS84 +units=m", (-600_000.0, -5_790_000.0))


def open_log(path):
    return StepLog(path, PLANS, DETECTORS, DEFENCES, ["e_0", ":j_0_0"], UTM)


@pytest.fixture
def scene():
    scene = Scene()
    scene.vehicles.rear_m[:] = [[100.0, 200.0], [300.0, 400.0], [0.0, 0.0], [0.0, 0.0]]
    scene.tracks.fix_m[:] = scene.vehicles.rear_m + 1.0
    scene.tracks.fix_valid[:] = True, False, True, True
    scene.tracks.residual_m[:] = 0.25
    scene.tracks.residual_valid[:] = False, True, True, True
    scene.tracks.plan[1] = 1
    scene.vehicles.lane_offset_m[:2] = 0.2, 0.3
    scene.seen.lane_poly[:2, 0] = -0.25, -0.35
    scene.seen.camera_valid[0] = True
    scene.vehicles.lane[1] = 1
    scene.estimate_m[:, 0] = scene.vehicles.rear_m + np.array([0.5, -0.5])
    scene.statistic[:, 0] = 7.0
    scene.scored[1, 0] = False
    scene.alarm[0, 0] = True
    scene.isolated[1, 1] = True
    return scene


def test_what_is_read_back_is_what_was_seen(tmp_path, scene):
    path = tmp_path / "steps.parquet"
    with open_log(path) as log:
        log.observe(scene.view(0, [0, 1]), ["a", "b"], scene.seen)
        assert not path.exists()
        log.observe(scene.view(1, [1]), ["b"], scene.seen)
    table = parquet.read_table(path).to_pydict()
    assert table["time_s"] == pytest.approx([0.1, 0.1, 0.2])
    assert table["vehicle_id"] == ["a", "b", "b"]
    assert table["plan"] == ["none", "constant_bias", "constant_bias"]
    assert table["lane"] == ["e_0", ":j_0_0", ":j_0_0"]
    assert table["x_m"] == [100.0, 300.0, 300.0]
    assert table["fix_y_m"] == [201.0, None, None]
    assert table["lane_offset_m"] == [0.2, 0.3, 0.3]
    assert table["camera_offset_m"] == [0.25, None, None]
    assert table["residual_m"] == [None, 0.25, 0.25]
    assert table["cusum_statistic"] == [7.0, None, None]
    assert table["cusum_alarm"] == [True, False, False]
    assert table["cusum+ukf_x_m"] == [100.5, 300.5, 300.5]
    assert table["cusum+ukf_y_m"] == [199.5, 399.5, 399.5]
    assert table["never+none_isolated"] == [False, True, True]
    back = UTM.from_lon_lat(np.array([table["lon_deg"], table["lat_deg"]]).T)
    np.testing.assert_allclose(back, [[100.0, 200.0], [300.0, 400.0], [300.0, 400.0]], atol=1e-6)
    fix = UTM.from_lon_lat(np.array([[table["fix_lon_deg"][0], table["fix_lat_deg"][0]]]))
    np.testing.assert_allclose(fix, [[101.0, 201.0]], atol=1e-6)
    assert table["fix_lon_deg"][1] is None


def test_rows_are_written_as_the_run_goes_on(tmp_path, scene, monkeypatch):
    monkeypatch.setattr(parquet_log, "ROWS_AT_ONCE", 4)
    with open_log(tmp_path / "steps.parquet") as log:
        for step in range(5):
            log.observe(scene.view(step, [0, 1]), ["a", "b"], scene.seen)
    file = parquet.ParquetFile(tmp_path / "steps.parquet")
    assert [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)] == [4, 4, 2]


def test_an_empty_run_gives_an_empty_file(tmp_path):
    with open_log(tmp_path / "steps.parquet"):
        pass
    assert parquet.read_table(tmp_path / "steps.parquet").num_rows == 0


def test_a_run_that_fails_leaves_nothing_behind(tmp_path, scene):
    def fail():
        with open_log(tmp_path / "steps.parquet") as log:
            log.observe(scene.view(0, [0]), ["a"], scene.seen)
            raise ValueError("the run")

    with pytest.raises(ValueError, match="the run"):
        fail()
    assert list(tmp_path.iterdir()) == []
