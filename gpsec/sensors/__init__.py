"""Synthetic sensors and their profiles."""
