"""Joins the stages: the one place that knows them all."""

from gpsec.pipeline.run import run_scenario

__all__ = ["run_scenario"]
