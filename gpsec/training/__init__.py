"""Trains and calibrates the detectors on benign traffic of the training networks."""

from gpsec.training.pool import TrainingProgress
from gpsec.training.rare import calibrate
from gpsec.training.train_models import Driving, train

__all__ = ["Driving", "TrainingProgress", "calibrate", "train"]
