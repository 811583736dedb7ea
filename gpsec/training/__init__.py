"""Trains and calibrates the detectors on benign traffic of the training networks."""

from gpsec.training.command import main

__all__ = ["main"]
