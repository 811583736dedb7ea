"""Real logs in the place of simulated sensors: the same attacks, detectors, filters and tables (docs/replay.md)."""
