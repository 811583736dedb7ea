"""Training with tapes: runs take them in turn, and calibration takes the same ones."""

import pytest

from gpsec.core.errors import GpsecError
from gpsec.sensors.registry import PROFILES
from gpsec.training.rare import calibrate
from gpsec.training.tapes import TrainingTapes
from gpsec.training.train_models import Driving, train
from gpsec.types.tapes import write_tape

from .test_collect import camera_tape


def test_runs_take_tapes_in_turn():
    tapes = TrainingTapes.of(["rendered-good", "rendered-night"])
    taken = [tapes.of_run(number, PROFILES["dsd"], 0.1).camera for number in range(4)]
    assert [one.condition for one in taken if one] == ["good", "night", "good", "night"]
    assert tapes.of_run(0, PROFILES["dsd"], 0.1).gnss is None
    assert set(tapes.digests) == {"rendered-good", "rendered-night"}


def test_no_tapes_leave_the_profile_alone():
    found = TrainingTapes.of(()).of_run(3, PROFILES["dsd"], 0.1)
    assert found.camera is None
    assert found.gnss is None


def test_a_tape_that_is_too_slow_or_not_there_is_refused(tmp_path):
    write_tape(camera_tape(1.0), tmp_path / "slow.npz")
    slow = TrainingTapes.of([str(tmp_path / "slow.npz")])
    with pytest.raises(GpsecError, match="rate_hz: expected 10 or more"):
        slow.of_run(0, PROFILES["dsd"], 0.1)
    with pytest.raises(GpsecError, match="unknown tape 'rendered-god'"):
        train(tmp_path / "models", driving=Driving(tapes=["rendered-god"]))
    assert not (tmp_path / "models").exists()


def test_calibration_takes_the_tapes_of_training(tmp_path):
    with pytest.raises(GpsecError, match=r"the tapes that dsd/tracked was trained with \(none\), found rendered-good"):
        TrainingTapes.of(["rendered-good"]).check_same({}, "dsd/tracked")
    tapes = TrainingTapes.of(["rendered-good"])
    tapes.check_same(dict(tapes.digests), "dsd/tracked")
    with pytest.raises(GpsecError, match="unknown tape"):
        calibrate(tmp_path, tapes=["rendered-god"])
