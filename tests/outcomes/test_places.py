import numpy as np
import pytest

from gpsec.core.geo import Projector
from gpsec.outcomes.tables import read_table

from .scene import Scene

UTM = Projector("+proj=utm +zone=32 +datum=WGS84 +units=m", (-600_000.0, -5_790_000.0))


@pytest.fixture
def table(tmp_path):
    """One vehicle that goes east by 1 m a step; attacked from step 2 on, seen in 4, out of its lane from 6 on."""
    scene = Scene(capacity=2)
    for step in range(9):
        if step == 2:
            scene.fork(0, 1, 1, step)
        scene.vehicles.rear_m[:] = float(step), 7.0
        scene.estimate_m[:] = scene.vehicles.rear_m[:, None]
        scene.estimate_m[:, 1, 1] += 2.0 * (step in {1, 6, 7})  # before the attack it is none of its doing
        scene.alarm[1, 0] = step >= 4
        scene.observe(step, [0, 1] if step >= 2 else [0])
    scene.close(1, "a")
    scene.close(0, "a")
    scene.outcomes.write(tmp_path, "lane", 1, replicates=5, projector=UTM)
    return read_table(tmp_path, "places")


def test_what_happened_where(table):
    found = [(row.what, row.by, row.x_m, row.y_m, round(row.time_s, 6)) for row in table.fillna("").itertuples()]
    assert found == [
        ("attack_began", "", 2.0, 7.0, 0.3),
        ("detected", "cusum", 4.0, 7.0, 0.5),
        ("left_lane", "never+none", 6.0, 7.0, 0.7),
    ]


def test_longitudes_and_latitudes_are_the_same_places(table):
    back = UTM.from_lon_lat(table[["lon_deg", "lat_deg"]].to_numpy())
    np.testing.assert_allclose(back, table[["x_m", "y_m"]].to_numpy(), atol=0.02)
