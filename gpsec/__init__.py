"""Evaluates GPS-spoofing attacks on automated vehicles at the scale of SUMO traffic."""

__version__ = "0.1.0"
