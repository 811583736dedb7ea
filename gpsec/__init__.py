"""Evaluates GPS-spoofing attacks on automated vehicles at the scale of SUMO traffic."""

