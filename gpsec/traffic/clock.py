"""How many steps a duration takes."""

from math import ceil


def step_count(duration_s: float, step_s: float) -> int:
    """Return how many steps of `step_s` cover `duration_s`, at least 0; rounding errors do not add one."""
    return max(0, ceil(duration_s / step_s - 1e-6))
