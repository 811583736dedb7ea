"""The reference itself: that it is no second name of the kernels, and does what its libraries do."""

import importlib
import pkgutil

import numpy as np
import pytest
import torch
from sklearn.ensemble import IsolationForest as SklearnForest

import gpsec.reference
from gpsec.core.errors import GpsecError
from gpsec.core.kernels import Compiled
from gpsec.detection.base import Detector
from gpsec.detection.forest_training import flatten
from gpsec.detection.lstm_training import ResidualLstm, to_arrays
from gpsec.filters.noise import FilterNoise
from gpsec.localization.rejoin import SwitchSettings
from gpsec.reference.detectors import detector_maker
from gpsec.reference.forecast import PlainNetwork
from gpsec.reference.forest import PlainForest
from gpsec.reference.history import Rules
from gpsec.reference.switch import TrackLocalization


def test_no_module_of_the_reference_knows_a_kernel():
    names = [module.name for module in pkgutil.iter_modules(gpsec.reference.__path__, "gpsec.reference.")]
    assert "gpsec.reference.switch" in names
    for name in names:
        known = vars(importlib.import_module(name))
        assert [key for key, value in known.items() if isinstance(value, Compiled)] == []
        modules = [value.__name__ for value in known.values() if type(value) is type(np)]
        assert [module for module in modules if module.startswith("gpsec")] == []


def test_forest_is_that_of_scikit_learn():
    generator = np.random.default_rng(2)
    forest = SklearnForest(n_estimators=15, max_samples=64, random_state=2).fit(generator.normal(size=(500, 5)))
    plain = PlainForest(flatten(forest))
    windows = (3.0 * generator.normal(size=(200, 5))).astype(np.float32)
    scores = [plain.score(window) for window in windows]
    assert scores == pytest.approx((-forest.score_samples(windows)).tolist(), abs=1e-12)


def test_network_is_that_of_torch():
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(4)
        model = ResidualLstm()
    inputs = np.random.default_rng(4).normal(size=(60, 4))
    with torch.inference_mode():
        expected = model.double()(torch.from_numpy(inputs)[None])[0].tolist()
    plain = PlainNetwork(to_arrays(model.float()))
    memory, found = plain.blank(), []
    for row in inputs.tolist():
        prediction, memory = plain.predict(row, memory)
        found.append(prediction)
    # The two biases of torch are added in float32 when the weights are stored.
    assert np.asarray(found) == pytest.approx(np.asarray(expected), abs=1e-6)


class Unheard(Detector):
    """A detector that only the kernels have."""

    name = "unheard"

    def new_state(self, capacity):
        raise NotImplementedError

    def update(self, state, seen, threshold, answers, column, threads=None):
        raise NotImplementedError


def test_what_has_no_reference_is_named():
    with pytest.raises(GpsecError, match=r"^the reference engine has no detector 'unheard': did you mean 'never'\?"):
        detector_maker(Unheard(), 1)
    rules = Rules(FilterNoise(*[1.0] * len(FilterNoise._fields)), SwitchSettings(), 0.1)
    with pytest.raises(GpsecError, match=r"^the reference engine has no response 'uk': did you mean 'ukf'\?"):
        TrackLocalization([0], ["uk"], rules)
