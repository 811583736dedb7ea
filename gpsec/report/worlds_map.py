"""The map of collisions: the net in its own coordinates, and where vehicles hit each other."""

from collections.abc import Iterator, Mapping
from math import nan
from typing import Any

import numpy as np

from gpsec.core.errors import GpsecError, shown
from gpsec.core.geo import Projector
from gpsec.outcomes.effects import BENIGN_PLAN
from gpsec.outcomes.naming import scenario_of_world
from gpsec.outcomes.worlds import COLLISION_KINDS
from gpsec.report.figure_data import Figure, Series
from gpsec.report.worlds_names import attack_name, by_world, where, world_label
from gpsec.running.results import Results
from gpsec.types.constants import MANIFEST

# More points than these hide each other, and make the file large.
_MOST_POINTS = 600
# Colour and mark of each kind.
_LOOKS = dict(zip(COLLISION_KINDS, ((4, "x"), (1, "diamond"), (0, "circle"), (3, "square")), strict=True))


def collision_map(run: Results) -> Figure:
    """Return the map of collisions, in the coordinates of the net."""
    series: list[Series] = []
    for name, stated in first_worlds(run).items():
        lines = [
            feature["geometry"]["coordinates"]
            for feature in run.map(stated["scenario"])
            if feature["properties"]["kind"] == "lane"
        ]
        if lines:
            position_m = projector_of(run, stated).from_lon_lat(np.concatenate([np.array(line) for line in lines]))
            joined = np.insert(np.round(position_m, 1), np.cumsum([len(line) for line in lines]), nan, axis=0)
            series.append(Series("lanes", "road", joined[:, 0], joined[:, 1], where={"group": name}))
    series += _points(run)
    return Figure(
        "map",
        "Where vehicles hit each other",
        "x in the net (m)",
        "y in the net (m)",
        series,
        "The run has no map.",
        "All seeds of a world. Touches of 1 m/s or more, in which gpsec drives one of the two; wreck: one of them had"
        " been hit before. Coordinates are those of the net, as sumo-gui shows them. Drag to move, scroll to zoom.",
        {"yaxis": {"scaleanchor": "x"}},
        tall=True,
    )


def _points(run: Results) -> Iterator[Series]:
    hits = {tuple(world.values()): rows for world, rows in by_world(run.worlds["collisions"])}
    for world, _ in by_world(run.worlds["worlds"]):
        if attack_name(world) == BENIGN_PLAN:
            continue
        place = {**where(world), "world": world_label(world)}
        mine = hits.get(tuple(world.values()))
        if mine is None:
            yield Series("no collision", "points", [], [], where=place)
            continue
        for kind in COLLISION_KINDS:
            rows = mine[mine["kind"] == kind]
            rows = rows.iloc[:: max(1, -(-len(rows) // _MOST_POINTS))]
            if rows.empty:
                continue
            colour, mark = _LOOKS[kind]
            text = [
                f"{row['vehicle_id']} and {row['other_id']}, {row['time_s']:.1f} s, {row['closing_mps']:.1f} m/s,"
                f" seed {row['seed']:.0f}"
                for row in rows.to_dict("records")
            ]
            x, y = rows["x_m"].to_numpy(), rows["y_m"].to_numpy()
            yield Series(kind, "points", x, y, colour=colour, where=place, text=text, mark=mark)


def first_worlds(run: Results) -> dict[str, dict[str, Any]]:
    """Return scenario -> manifest of its first world."""
    found: dict[str, dict[str, Any]] = {}
    for stated in run.scenarios:
        found.setdefault(scenario_of_world(stated["scenario"]), stated)
    return found


def projector_of(run: Results, stated: Mapping[str, Any]) -> Projector:
    """Return how positions in the net of a world come from longitude and latitude.

    Raises:
        GpsecError: the manifest does not say it.
    """
    net = stated["closed_loop"].get("net") if isinstance(stated.get("closed_loop"), dict) else None
    source = f"{run.folder / MANIFEST}: {stated['scenario']}: closed_loop.net"
    try:
        definition, (east_m, north_m) = str(net["projection"]), map(float, net["offset_m"])  # type: ignore[index]
    except (TypeError, KeyError, ValueError):
        raise GpsecError(f"{source}: expected projection and offset_m of the net, found {shown(net)}") from None
    return Projector(definition, (east_m, north_m), source=source)
