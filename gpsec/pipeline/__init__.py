"""Joins the stages: the one place that knows them all."""
