from functools import cache

import numpy as np
import pytest

from gpsec.detection import forest_training, lstm_training
from gpsec.detection.models import ProfileModel
from gpsec.detection.training import train_one
from gpsec.testing.residuals import make_log
from gpsec.testing.watched import watched_log


@cache
def _trained() -> ProfileModel:
    """Return models of small synthetic logs; made once for all tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lstm_training, "EPOCHS", 12)
        patch.setattr(forest_training, "SAMPLES", 256)
        return train_one([make_log(60, 500, seed=1)], [watched_log(make_log(60, 700, seed=2))], seed=3)


@pytest.fixture(scope="session")
def model() -> ProfileModel:
    return _trained()


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)
