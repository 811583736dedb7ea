"""Residuals like those of the loop: white noise, slow GNSS error, chord error in curves, gaps in junctions."""

from dataclasses import replace

import numpy as np

from gpsec.detection.logs import Grid, ResidualLog
from gpsec.testing.contract import STEP_S

SCALE_M = 0.3


def make_log(
    vehicles: int = 40,
    steps: int = 600,
    seed: int = 0,
    white: float = 0.5,
    slow: float = 0.8,
    tau_s: float = 60.0,
    chord_m: float = 0.2,
    gaps: bool = True,
) -> ResidualLog:
    """Return a benign log; `white` and `slow` are standard deviations in units of the scale of 0.3 m."""
    rng = np.random.default_rng(seed)
    shape = (vehicles, steps)
    decay = np.exp(-STEP_S / tau_s)
    bias = rng.normal(size=vehicles)
    level = np.empty(shape)
    for t in range(steps):
        level[:, t] = bias
        bias = decay * bias + np.sqrt(1.0 - decay**2) * rng.normal(size=vehicles)
    phase = rng.uniform(0.0, 60.0, vehicles)[:, None] + np.arange(steps) * STEP_S
    # Every 60 s: a bend of 1/50 m for 8 s, and a junction of 4 s.
    bend = np.where((phase % 60.0 > 10.0) & (phase % 60.0 < 18.0), 0.02, 0.0)
    valid = np.ones(shape, np.bool_)
    if gaps:
        valid = (phase % 60.0 < 40.0) | (phase % 60.0 > 44.0)
        valid &= rng.uniform(size=shape) > 0.01
    residual = SCALE_M * (white * rng.normal(size=shape) + slow * level) + chord_m * bend / 0.02
    return ResidualLog(
        network="synthetic",
        profile="carla",
        association="tracked",
        step_s=STEP_S,
        scale_m=SCALE_M,
        vehicle=np.repeat(np.arange(vehicles, dtype=np.int32), steps),
        step=np.tile(np.arange(steps, dtype=np.int32), vehicles),
        residual_m=np.where(valid, residual, 0.0).ravel(),
        valid=valid.ravel(),
        speed_mps=np.full(vehicles * steps, 12.0),
        curvature_per_m=(bend + 1e-3 * rng.normal(size=shape)).ravel(),
        camera_sigma_m=(0.08 + 2.0 * bend).ravel(),
    )


def spoofed(grid: Grid, first: int, offset_m: float) -> Grid:
    """Return residuals that are moved from step `first` on."""
    residual = grid.residual_m.copy()
    residual[first:] += np.where(grid.valid[first:], offset_m, 0.0)
    return replace(grid, residual_m=residual, channels=None)


def benign(vehicles: int = 24, steps: int = 260, seed: int = 9) -> Grid:
    """Return residuals with noise, bends, junctions and gaps."""
    return Grid.of([make_log(vehicles, steps, seed=seed)])


def noiseless(vehicles: int, steps: int) -> Grid:
    """Return valid residuals of exactly zero."""
    return Grid.of([make_log(vehicles, steps, seed=0, white=0.0, slow=0.0, chord_m=0.0, gaps=False)])


def with_gap(gap: int, bias: float = 8.0, after: float = 0.0, total: int = 300) -> Grid:
    """Return residuals of `bias` scales from step 60, none from step 100 for `gap` steps, then of `after` scales."""
    grid = noiseless(1, total)
    grid.residual_m[60:100] = bias * SCALE_M
    grid.residual_m[100 + gap :] = after * SCALE_M
    grid.valid[100 : 100 + gap] = False
    grid.residual_m[100 : 100 + gap] = 0.0
    return grid
