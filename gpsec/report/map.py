"""The map of a run: lanes and zones, where attacks began, were seen, and vehicles left their lane."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from gpsec.core.geo import Projector
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.places import ATTACK_BEGAN, DETECTED, LEFT_LANE
from gpsec.outcomes.tables import whole
from gpsec.report.figure_data import NEUTRAL, Figure, Series, group_name
from gpsec.report.figures import defences_of, detectors_of
from gpsec.report.formatting import figure
from gpsec.running.results import Results
from gpsec.types.constants import UNDEFENDED

# Length of a degree of latitude, and of longitude at the equator.
_DEGREE_M = 111_320.0
# Steps of the colour of streets.
_LEVELS = 4
# More points than these hide each other, and make the file large.
_MOST_POINTS = 600


def map_figure(run: Results) -> Figure:
    """Return the map in the net's own coordinates, with the streets on which vehicles left their lane.

    Where a map of an older version does not say which these are, it is in metres from the middle of the lanes.
    """
    series: list[Series] = []
    known = {DETECTED: detectors_of(run), LEFT_LANE: defences_of(run)}
    thinned = False
    for scenario in run.scenarios:
        name = scenario["scenario"]
        features = run.map(name)
        places = run.places[run.places["scenario"] == name]
        groups = [group_name(name, profile) for profile in scenario["profiles"]]
        if not features and places.empty:
            continue
        at = _Frame(run.frame(name), _middle(features, places))
        lines = [feature for feature in features if feature["properties"]["kind"] == "lane"]
        zones = [feature for feature in features if feature["properties"]["kind"] == "zone"]
        off = [feature for feature in features if feature["properties"]["kind"] == "multipath"]
        for group in groups:
            if lines:
                x, y = _joined([feature["geometry"]["coordinates"] for feature in lines], at)
                series.append(Series("lanes", "road", x, y, where={"group": group}))
            for zone in zones:
                x, y = _joined(zone["geometry"]["coordinates"], at)
                plan = zone["properties"]["id"]
                series.append(Series(f"zone {plan}", "area", x, y, colour=5, where={"group": group, "attack": plan}))
            if off:
                x, y = _joined([ring for feature in off for ring in feature["geometry"]["coordinates"]], at)
                series.append(Series("multipath", "area", x, y, colour=3, where={"group": group}))
        series += _streets(run, name, lines, at)
        x_all, y_all = at.metres(places[["lon_deg", "lat_deg"]].to_numpy())
        vehicles, times = places["vehicle_id"].to_numpy(), places["time_s"].to_numpy()
        lon, lat = places["lon_deg"].to_numpy(), places["lat_deg"].to_numpy()
        keys = ["profile", "attack", "what", "by"]
        found = places.groupby(keys, sort=False, observed=True, dropna=False).indices
        for names, rows in sorted(found.items(), key=lambda item: int(item[1][0])):
            profile, attack, what, by = map(str, names)
            where = {"group": group_name(name, profile), "attack": attack}
            if what == ATTACK_BEGAN:
                label, colour, mark = "attack began", NEUTRAL, "circle-open"
            elif by not in known[what]:
                continue
            elif what == DETECTED:
                label, colour, mark = f"seen by {by}", 2, "triangle-up"
                where["detector"] = by
            else:
                label, colour, mark = f"left its lane with {by}", 4, "x"
                where["defence"] = by
            thinned |= len(rows) > _MOST_POINTS
            shown = rows[:: math.ceil(len(rows) / _MOST_POINTS)]
            text = [f"{vehicles[row]}, {times[row]:.1f} s, {lon[row]:.5f} {lat[row]:.5f}" for row in shown]
            x, y = x_all[shown], y_all[shown]
            series.append(Series(label, "points", x, y, colour=colour, where=where, text=text, mark=mark))
    return Figure(
        "map",
        "Where it happened",
        "east (m)",
        "north (m)",
        series,
        "The run has no map and no attack of this kind.",
        "Where attacks began, where the chosen detector saw them, and where vehicles would have left their lane with"
        f" the chosen defence ({UNDEFENDED} is the undefended vehicle); streets by the departures in an hour that"
        " attacked vehicles drove there. In the net's own coordinates; points say longitude and latitude. Drag to move,"
        " scroll to zoom."
        + (f" Of more than {_MOST_POINTS} points of a kind, some are left out; places.csv has all." if thinned else ""),
        {"yaxis": {"scaleanchor": "x"}},
        tall=True,
    )


def _middle(features: Sequence[dict[str, Any]], places: pd.DataFrame) -> np.ndarray:
    lanes = [feature["geometry"]["coordinates"] for feature in features if feature["properties"]["kind"] == "lane"]
    corners = np.concatenate(lanes) if lanes else places[["lon_deg", "lat_deg"]].to_numpy()
    middle: np.ndarray = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    return middle


@dataclass(frozen=True)
class _Frame:
    """Where places are drawn: in the net's frame, or from the middle of its lanes where that is not known."""

    projector: Projector | None
    middle: np.ndarray

    def metres(self, lon_lat_deg: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return east and north of (n, 2) longitudes and latitudes."""
        if self.projector is not None:
            away = self.projector.from_lon_lat(lon_lat_deg)
        else:
            away = (lon_lat_deg - self.middle) * _DEGREE_M
            away[:, 0] *= math.cos(math.radians(self.middle[1]))
        return np.round(away[:, 0], 1), np.round(away[:, 1], 1)


def lines_of_edges(run: Results, scenario: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the points of the lanes of each edge: (n, 2) as the map shows them, and (n, 2) longitudes and latitudes.

    Of a scenario over several seeds they are those of its first run.
    """
    name = next(
        each["scenario"] for each in run.scenarios if scenario in (each["scenario"], base_name(each["scenario"]))
    )
    features = run.map(name)
    at = _Frame(run.frame(name), _middle(features, run.places[run.places["scenario"] == name])) if features else None
    lines: dict[str, list[Any]] = {}
    for feature in features:
        if feature["properties"]["kind"] == "lane":
            edge = feature["properties"]["id"].rpartition("_")[0]
            lines.setdefault(edge, []).extend(feature["geometry"]["coordinates"])
    degrees = {edge: np.array(points, np.float64) for edge, points in lines.items()}
    return {edge: (np.stack(at.metres(points), axis=1), points) for edge, points in degrees.items() if at is not None}


def _streets(run: Results, scenario: str, lines: Sequence[dict[str, Any]], at: _Frame) -> list[Series]:
    """Return the edges on which vehicles left their lane, in `_LEVELS` of the rate, for each attack and defence."""
    shapes: dict[str, list[Any]] = {}
    for line in lines:
        shapes.setdefault(line["properties"]["id"].rpartition("_")[0], []).append(line["geometry"]["coordinates"])
    rows = run.streets[(run.streets["scenario"] == scenario) & (run.streets["departures"] > 0)]
    made = []
    rate = "departures_per_vehicle_hour"
    for names, found in rows.groupby(["profile", "attack", "defence"], sort=False, observed=True):
        profile, attack, defence = map(str, names)
        where = {"group": group_name(scenario, profile), "attack": attack, "defence": defence}
        level = np.minimum(found[rate].to_numpy() / found[rate].max() * _LEVELS, _LEVELS - 1).astype(int)
        for number in range(_LEVELS):
            edges = found[level == number]
            drawn = [shape for edge in edges["edge"] for shape in shapes.get(str(edge), [])]
            if drawn:
                x, y = _joined(drawn, at)
                least, most = figure(edges[rate].min()), figure(edges[rate].max())
                title = f"departures an hour driven: {least}" + (f" to {most}" if most != least else "")
                made.append(Series(title, "heat", x, y, colour=number, where=where))
    return made


def _joined(lines: Sequence[Any], at: _Frame) -> tuple[list[float], list[float]]:
    """Return the points of several lines as one, with a gap after each."""
    x: list[float] = []
    y: list[float] = []
    for line in lines:
        east, north = at.metres(np.asarray(line, np.float64))
        x += [*east, math.nan]
        y += [*north, math.nan]
    return x, y


PLACES = "places.geojson"


def write_places(run: Results, path: Path | None = None) -> Path:
    """Write lanes, zones and places as one GeoJSON collection in WGS84 (RFC 7946); return its path."""
    features: list[dict[str, Any]] = []
    for stated in run.scenarios:
        for feature in run.map(stated["scenario"]):
            features.append(feature | {"properties": {"scenario": stated["scenario"]} | feature["properties"]})
    for row in run.places.astype(object).to_dict("records"):
        properties = {
            "scenario": row["scenario"],
            "kind": row["what"],
            "by": None if pd.isna(row["by"]) else row["by"],
            "attack": row["attack"],
            "vehicle_id": row["vehicle_id"],
            "profile": row["profile"],
            "time_s": round(row["time_s"], 3),
        }
        point = {"type": "Point", "coordinates": [row["lon_deg"], row["lat_deg"]]}
        features.append({"type": "Feature", "properties": properties, "geometry": point})
    target = path or run.folder / PLACES
    with whole(target) as partial:
        text = json.dumps({"type": "FeatureCollection", "features": features}, separators=(",", ":"))
        partial.write_text(text + "\n", encoding="utf-8")
    return target
