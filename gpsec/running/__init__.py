"""Runs scenarios, each in a process of its own, and reads their results."""
