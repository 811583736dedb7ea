"""Taxi: the sensors of a fleet of taxis."""

from gpsec.sensors.registry import PROFILES

TAXI = PROFILES["dsd"].model_copy(update={"name": "taxi", "title": "a fleet of taxis with the sensors of dsd"})
