"""Roads made by hand: two lines of paint along a straight or an arc, seen from a vehicle beside their middle."""

from math import cos, sin

import numpy as np

from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.paint import SURFACE, WHITE_PAINT, YELLOW_PAINT
from gpsec.imaging.pictures.render import Renderer
from gpsec.imaging.pictures.scene import Moment, SeenBodies
from gpsec.imaging.pictures.strips import Painted, join_strips
from gpsec.imaging.pictures.weather import WEATHERS

NOBODY = SeenBodies(np.zeros((0, 2)), *(np.zeros(0) for _ in range(4)), np.zeros(0, np.uint64))


def strip(offset_m: float, width_m: float, kind: int, bend: float = 0.0):
    """A strip whose middle is left of a line that starts at the origin to the east, with that curvature."""
    s = np.arange(-5.0, 90.0, 1.0)
    angle = bend * s
    if bend:
        middle = np.stack([np.sin(angle) / bend, (1.0 - np.cos(angle)) / bend], axis=1)
    else:
        middle = np.stack([s, np.zeros(len(s))], axis=1)
    left = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    ends = [middle + (offset_m + side * width_m) * left for side in (0.5, -0.5)]
    return ends[0], ends[1], kind, np.zeros(len(s))


def road(width_m: float = 3.5, bend: float = 0.0, *, paint: bool = True) -> Painted:
    lines = [strip(0.5 * width_m, 0.15, YELLOW_PAINT, bend), strip(-0.5 * width_m, 0.15, WHITE_PAINT, bend)]
    return Painted.of(join_strips([strip(0.0, 12.0, SURFACE, bend), *(lines if paint else [])]))


def view(
    ground: Painted,
    offset_m: float,
    *,
    camera: RoadCamera | None = None,
    turn: float = 0.0,
    others: SeenBodies = NOBODY,
):
    """The noiseless picture of a vehicle that is `offset_m` left of the middle, 10 m along a straight road."""
    moment = Moment(0, np.array([10.0, offset_m]), turn, others)
    return Renderer(camera or RoadCamera(), ground, WEATHERS["noiseless"]).picture(moment)


def on_arc(ground: Painted, bend: float, offset_m: float):
    """The same on an arc."""
    a = 10.0 * bend
    place = np.array([sin(a), 1.0 - cos(a)]) / bend + offset_m * np.array([-sin(a), cos(a)])
    return Renderer(RoadCamera(), ground, WEATHERS["noiseless"]).picture(Moment(0, place, a, NOBODY))
