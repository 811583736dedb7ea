"""Spoofers at a place that a plan names by coordinates or by an edge: without netedit."""

from collections.abc import Sequence

import numpy as np

from gpsec.attacks.plans import PlanConfig
from gpsec.attacks.zones import Zone
from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.hdmap.map import HDMap


def placed_zones(plans: Sequence[PlanConfig], hd_map: HDMap, file: str) -> dict[str, Zone]:
    """Return the zone of each plan that is placed, by the plan's name.

    Raises:
        GpsecError: its edge is unknown, its net has no longitudes, or no lane is within its reach.
    """
    found = {}
    for number, plan in enumerate(plans):
        if not plan.placed:
            continue
        where = f"{file}: plans[{number}]"
        if plan.edge is not None:
            centre_m = _middle_of(plan.edge, hd_map, where)
        else:
            if not hd_map.projector.has_projection:
                raise GpsecError(
                    f"{where}: at: expected a net that says where on the Earth it lies, found one without a projection;"
                    " name an edge instead"
                )
            centre_m = hd_map.projector.from_lon_lat(np.array(plan.at))
            _check_reach(centre_m, plan.radius_m or 0.0, hd_map, where)
        found[plan.name] = Zone(plan.name, centre_m[None, :], plan.radius_m)
    return found


def _middle_of(edge: str, hd_map: HDMap, where: str) -> Floats:
    """Return the point half-way along the edge's first lane.

    Raises:
        GpsecError: there is no such edge.
    """
    first: dict[str, int] = {}
    for lane, name in enumerate(hd_map.lane_ids):
        first.setdefault(name.rpartition("_")[0], lane)
    if edge not in first:
        known = [name for name in first if not name.startswith(":")]
        raise GpsecError(f"{where}: edge: expected an edge of the net, found '{shown(edge)}': {nearest(edge, known)}")
    line = hd_map.centre_line(first[edge])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    return np.array([np.interp(0.5 * along[-1], along, line[:, axis]) for axis in (0, 1)])


def _check_reach(centre_m: Floats, radius_m: float, hd_map: HDMap, where: str) -> None:
    lanes = range(len(hd_map.lane_ids))
    away = [_distance(centre_m, hd_map.centre_line(lane)) for lane in lanes]
    closest = int(np.argmin(away))
    if away[closest] > radius_m:
        edge = hd_map.lane_ids[closest].rpartition("_")[0]
        raise GpsecError(
            f"{where}: at: expected a place with a lane within its radius_m of {radius_m:g} m, found the nearest one,"
            f" of edge '{shown(edge)}', {away[closest]:.0f} m away"
        )


def _distance(point_m: Floats, line_m: Floats) -> float:
    """Return the distance of a point from a line of (n, 2) points."""
    start, way = line_m[:-1], np.diff(line_m, axis=0)
    length2 = np.maximum(np.sum(way * way, axis=1), 1e-12)
    share = np.clip(np.sum((point_m - start) * way, axis=1) / length2, 0.0, 1.0)
    return float(np.min(np.hypot(*(start + share[:, None] * way - point_m).T)))
