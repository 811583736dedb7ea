"""Contacts of vehicles by brute force: shapely's polygons, and the Minkowski sum for the time until they touch."""

from math import inf

import numpy as np
import shapely

from gpsec.core.arrays import Flags
from gpsec.encounters.rectangles import Bodies


def outline(bodies: Bodies, i: int) -> shapely.Polygon:
    """Return a body as a polygon."""
    u = np.array([bodies.ux[i], bodies.uy[i]])
    n = np.array([-u[1], u[0]])
    centre = np.array([bodies.x_m[i], bodies.y_m[i]])
    along, across = bodies.half_length_m[i] * u, bodies.half_width_m[i] * n
    return shapely.Polygon([centre + a * along + b * across for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))])


def overlapping(bodies: Bodies) -> Flags:
    """Return the (B, B) matrix of which bodies overlap; the diagonal is false."""
    shapes = np.array([outline(bodies, i) for i in range(len(bodies.x_m))])
    found = shapely.intersects(shapes[:, None], shapes[None, :])
    np.fill_diagonal(found, False)
    return np.asarray(found)


def seconds_to_contact(bodies: Bodies, i: int, j: int) -> float:
    """Return when two bodies that go straight on touch, infinite where they never do.

    They touch once the way of j, as seen from i, enters the Minkowski sum of i and of j turned about its centre.
    """
    ours, theirs = outline(bodies, i), outline(bodies, j)
    centre = np.array([bodies.x_m[j], bodies.y_m[j]])
    corners = [
        np.array(a) - (np.array(b) - centre) for a in ours.exterior.coords[:4] for b in theirs.exterior.coords[:4]
    ]
    forbidden = shapely.MultiPoint(corners).convex_hull
    if forbidden.contains(shapely.Point(centre)):
        return 0.0
    way = np.array([bodies.vx_mps[j] - bodies.vx_mps[i], bodies.vy_mps[j] - bodies.vy_mps[i]])
    speed = float(np.hypot(*way))
    if speed <= 1e-9:
        return inf
    far_m = 1e4
    met = shapely.LineString([centre, centre + far_m * way / speed]).intersection(forbidden)
    return inf if met.is_empty else float(shapely.Point(centre).distance(met)) / speed
