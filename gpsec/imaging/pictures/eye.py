"""One vehicle that looks: its camera as it is mounted, the pictures that it takes, and the lanes in them."""

from dataclasses import dataclass, field
from functools import cached_property

from gpsec.hdmap.map import HDMap
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.lanes import NO_LANE, LaneFinder, SeenLane
from gpsec.imaging.pictures.memory import LaneMemory
from gpsec.imaging.pictures.mounting import camera_on, misaligned
from gpsec.imaging.pictures.paint import paint_roads
from gpsec.imaging.pictures.render import Renderer
from gpsec.imaging.pictures.scene import Moment
from gpsec.imaging.pictures.strips import Painted
from gpsec.imaging.pictures.weather import Weather


class LaneEye:
    """A vehicle's view of its lane, picture by picture.

    Attributes:
        pictures, lanes: how many were taken, and in how many of them there was a lane.
        said: the last lane that it was sure of.
    """

    def __init__(self, renderer: Renderer, finder: LaneFinder, memory: LaneMemory | None) -> None:
        self.pictures, self.lanes = 0, 0
        self.said = NO_LANE
        self._renderer, self._finder, self._memory = renderer, finder, memory
        self._seen: SeenLane | None = None
        self._moved: tuple[float, float] | None = None

    def look(self, moment: Moment, width_m: float) -> None:
        """Take a picture and find the lane in it, which is so wide by the map."""
        self._seen = self._finder.find(self._renderer.picture(moment), width_m)
        self.pictures += 1
        self.lanes += self._seen.valid

    def rest(self) -> None:
        """Take no picture where there is no lane to be seen, and forget the last ones."""
        self._moved = None

    def say(self, way_m: float, turn_rad: float) -> SeenLane:
        """Return the lane by the picture of this step, after so much way and turn in it; none without a picture."""
        if self._moved is not None:
            self._moved = self._moved[0] + way_m, self._moved[1] + turn_rad
        if self._seen is None:
            return NO_LANE
        seen = self._seen if self._memory is None else self._memory.take(self._seen, self._moved)
        self._seen, self._moved = None, (0.0, 0.0)
        if seen.valid:
            self.said = seen
        return seen


@dataclass(frozen=True)
class Optics:
    """What all eyes of a run have in common.

    Attributes:
        hd_map: the roads.
        weather: in all pictures.
        mounting_deg: standard deviation of how cameras are mounted, on each axis, unknown to them.
        memory_m: way over which what was seen is averaged; None for single pictures.
    """

    hd_map: HDMap
    weather: Weather
    mounting_deg: float
    memory_m: float | None = None
    _finders: dict[RoadCamera, LaneFinder] = field(default_factory=dict, compare=False)

    @cached_property
    def ground(self) -> Painted:
        """The roads with their paint."""
        return paint_roads(self.hd_map, 0)

    def eye(self, axle_m: float, key: int) -> LaneEye:
        """Return the eye of the vehicle `key`, whose front bumper is `axle_m` ahead of its rear axle."""
        camera = camera_on(axle_m)
        finder = self._finders.setdefault(camera, LaneFinder(camera))
        renderer = Renderer(misaligned(camera, key, self.mounting_deg), self.ground, self.weather, key)
        return LaneEye(renderer, finder, None if self.memory_m is None else LaneMemory(self.memory_m))
