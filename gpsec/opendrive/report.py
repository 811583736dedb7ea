"""Writes a check: a CSV with a row for each lane, and a picture of the lanes coloured by their error."""

import csv
from pathlib import Path

import numpy as np

from gpsec.opendrive.check import Check, MapDeviation
from gpsec.opendrive.polylines import stations

CHECK_COLUMNS = (
    "road",
    "lane_section",
    "lane",
    "type",
    "begin_m",
    "length_m",
    "points",
    "unmatched_share",
    "median_m",
    "p95_m",
    "largest_m",
    "mean_m",
)
_LOWEST_M, _HIGHEST_M = 1e-3, 1.0
_INCHES, _DPI = 10.0, 160


def write_csv(check: Check, path: Path) -> None:
    """Write a row for each lane of each lane section of the map; an empty cell is an undefined figure."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(CHECK_COLUMNS)
        for line, figures in zip(check.lines, check.by_lane, strict=True):
            place = f"{line.station_m.min():.3f}", f"{stations(line.points_m)[-1]:.3f}"
            writer.writerow([line.road_id, line.section, line.lane_id, line.kind, *place, *_cells(figures)])


def _cells(figures: MapDeviation) -> list[str]:
    distances = (figures.median_m, figures.p95_m, figures.largest_m, figures.mean_m)
    written = ["" if value is None else f"{value:.4f}" for value in distances]
    return [str(figures.points), f"{figures.unmatched_share:.4f}", *written]


def draw_check(check: Check, path: Path, title: str) -> None:
    """Draw the map's lanes as a PNG, coloured by how far the net's lanes lie beside them, grey where there is none."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    pieces = np.concatenate([np.stack([line.points_m[:-1], line.points_m[1:]], axis=1) for line in check.lines])
    across = np.concatenate([np.abs(values[:-1]) for values in check.across_m])
    low, high = pieces.reshape(-1, 2).min(axis=0), pieces.reshape(-1, 2).max(axis=0)
    wide, tall = np.maximum(high - low, 0.3 * (high - low).max())
    shape = (_INCHES, _INCHES * tall / wide + 1.0) if wide > tall else (_INCHES * wide / tall + 2.0, _INCHES)
    figure = Figure(figsize=shape, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    missing = np.isnan(across)
    axes.add_collection(LineCollection(list(pieces[missing]), colors="0.6", linewidths=1.0))
    lines = LineCollection(list(pieces[~missing]), cmap="viridis", norm=LogNorm(_LOWEST_M, _HIGHEST_M), linewidths=1.2)
    lines.set_array(np.clip(across[~missing], _LOWEST_M, _HIGHEST_M))
    axes.add_collection(lines)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(title=title, xlabel="x (m)", ylabel="y (m)")
    figure.colorbar(lines, ax=axes, label="across the lane, net against map (m)", extend="both")
    figure.savefig(path, dpi=_DPI, metadata={"Software": None})
