"""Front views of any vehicle: road, paint, other vehicles, light, rain, lens and sensor."""

from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.tables import taken
from gpsec.imaging.pictures.bodies import draw_bodies
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.imaging.pictures.opencv import opencv
from gpsec.imaging.pictures.paint import SEAM, SHADE, SURFACE, WHITE_PAINT, YELLOW_PAINT
from gpsec.imaging.pictures.scene import Moment, in_frame_of
from gpsec.imaging.pictures.strips import Painted, Strips, runs
from gpsec.imaging.pictures.weather import Weather

_REACH_M = 80.0
_SHIFT = 4
# How strong paint is drawn: steps between none and all.
_LEVELS = 8
# Shadows of trees leave so much of the light.
_SHADE_LIGHT = 0.45
# Headlamps: the low beam ends here (ECE R 112: the cut-off of a lamp 0.65 m high falls 1 %).
_BEAM_M = 65.0
_TILE = 512


@dataclass(frozen=True)
class Renderer:
    """Makes pictures; the same moment gives the same one.

    Attributes:
        camera: as it is mounted, which is not quite as its vehicle believes.
        ground: of the net.
        weather: in all pictures.
        key: of the noise.
    """

    camera: RoadCamera
    ground: Painted
    weather: Weather
    key: int = 0
    _noise: dict[str, np.ndarray] = field(default_factory=dict)

    def picture(self, moment: Moment) -> np.ndarray:
        """Return the (height, width, 3) picture of a moment, blue, green, red."""
        cv2, weather = opencv(), self.weather
        draw = np.random.default_rng([self.key, moment.step])
        picture = self._backdrop.copy()
        near = self.ground.near(moment.rear_m, _REACH_M)
        if not weather.shadows:
            near = taken(near, near.kind != SHADE)
        self._draw_strips(picture, near, moment)
        draw_bodies(picture, self.camera, moment, 1.0 - weather.daylight)
        if weather.blur_px > 0.0:
            picture = cv2.GaussianBlur(picture, (0, 0), weather.blur_px)
        if weather.daylight < 1.0:
            picture = cv2.multiply(picture, self._light, scale=1.0 / 255.0)
        if weather.wet > 0.0:
            picture = cv2.add(picture, self._mirror)
        if weather.drops:
            self._wet_screen(picture, moment.step, draw)
        if weather.noise > 0.0:
            self._add_noise(picture, draw)
        return picture

    def _draw_strips(self, picture: np.ndarray, strips: Strips, moment: Moment) -> None:
        cv2, weather = opencv(), self.weather
        left, right = in_frame_of(moment, strips.left_m), in_frame_of(moment, strips.right_m)
        middle = 0.5 * (left + right)
        shown = (np.minimum(left[:, 0], right[:, 0]) > self.camera.x_m + 1.0) & (middle[:, 0] < _REACH_M)
        shown &= np.abs(middle[:, 1]) < 12.0 + middle[:, 0]
        strength = np.clip(1.0 - weather.worn * np.maximum(strips.wear - 0.25, 0.0) / 0.75, 0.0, 1.0)
        level = np.ceil(_LEVELS * strength).astype(np.int32)
        level[(strips.kind != WHITE_PAINT) & (strips.kind != YELLOW_PAINT)] = _LEVELS
        pixels = self._pixels(left, right)
        shadows = None
        for run in runs(strips, shown, level):
            kind, share = int(strips.kind[run.start]), float(level[run.start + 1]) / _LEVELS
            if share == 0.0:
                continue
            points = np.concatenate([pixels[0][run], pixels[1][run][::-1]])
            if kind == SHADE:
                shadows = np.full(picture.shape[:2], 255, np.uint8) if shadows is None else shadows
                cv2.fillPoly(shadows, [points], int(255 * _SHADE_LIGHT), cv2.LINE_8, _SHIFT)
            elif kind == SURFACE:
                cv2.fillPoly(picture, [points], _tone(weather, kind, 1.0), cv2.LINE_8, _SHIFT)
            else:
                cv2.fillPoly(picture, [points], _tone(weather, kind, share), cv2.LINE_AA, _SHIFT)
        if shadows is not None:
            soft = cv2.blur(shadows, (5, 3))
            cv2.multiply(picture, cv2.merge([soft, soft, soft]), picture, 1.0 / 255.0)

    def _pixels(self, left: Floats, right: Floats) -> tuple[Ints, Ints]:
        """Return both ends of cross sections in fixed-point pixels, drawn in by what a filled edge gains in width."""
        flat = np.zeros((len(left) + len(right), 3))
        flat[:, :2] = np.concatenate([left, right])
        pixels, _ = self.camera.project(flat)
        a, b = pixels[: len(left)], pixels[len(left) :]
        wide = np.abs(b - a).sum(axis=1, keepdims=True)
        inwards = np.minimum(0.5 / np.maximum(wide, 1e-9), 0.25) * (b - a)
        a, b = a + inwards, b - inwards
        fixed = [np.clip(np.round(ends * (1 << _SHIFT)), -1e6, 1e6).astype(np.int32) for ends in (a, b)]
        return fixed[0], fixed[1]

    @cached_property
    def _distance_m(self) -> Floats:
        """Distance on the road, (height, width), of each pixel; infinite over the horizon."""
        rows, columns = np.mgrid[0 : self.camera.height, 0 : self.camera.width]
        ground = self.camera.on_road(np.stack([columns.ravel(), rows.ravel()], axis=1).astype(np.float64))
        ahead: Floats = np.where(np.isfinite(ground[:, 0]), ground[:, 0], np.inf).reshape(rows.shape)
        return ahead

    @cached_property
    def _backdrop(self) -> np.ndarray:
        """Sky and verge, where nothing else is."""
        weather, ahead = self.weather, self._distance_m
        tones = np.empty((*ahead.shape, 3))
        rough = np.random.default_rng(self.key).normal(0.0, 12.0, ahead.shape)
        tones[...] = (
            np.array([0.75, 1.0, 0.85]) * (weather.verge + opencv().GaussianBlur(rough, (0, 0), 2.0))[..., None]
        )
        tones[np.isinf(ahead)] = weather.sky
        return np.clip(tones, 0.0, 255.0).astype(np.uint8)

    @cached_property
    def _light(self) -> np.ndarray:
        """Light on each pixel, 255 for that of day: what is left of it, and one's own beams."""
        weather, camera, ahead = self.weather, self.camera, self._distance_m
        aside = np.abs(np.arange(camera.width) - camera.cx) / camera.fx
        # A beam is even up to some 25 m, then falls with the square of the distance, and it ends at the cut-off.
        far = np.maximum(ahead - camera.x_m, 1.0)
        beam = (
            np.minimum(1.0, (25.0 / far) ** 2)
            * np.clip((_BEAM_M - far) / 15.0, 0.0, 1.0)
            * np.exp(-((aside / 0.45) ** 2))
        )
        light = np.clip(weather.daylight + weather.headlights * np.where(np.isfinite(ahead), beam, 0.0), 0.0, 1.0)
        return np.repeat((255.0 * light).astype(np.uint8)[..., None], 3, axis=2)

    @cached_property
    def _mirror(self) -> np.ndarray:
        """What a wet road mirrors of the sky: the more the flatter one looks (Schlick's approximation, 1994)."""
        weather, ahead = self.weather, self._distance_m
        flat = np.clip(1.0 - self.camera.z_m / np.maximum(ahead, 1.0), 0.0, 1.0) ** 5
        grey = np.where(np.isfinite(ahead), weather.wet * weather.daylight * weather.sky * flat, 0.0)
        return np.repeat(grey.astype(np.uint8)[..., None], 3, axis=2)

    def _wet_screen(self, picture: np.ndarray, step: int, draw: np.random.Generator) -> None:
        """Blur the picture where drops are: they stay for half a second, until the wiper comes, and fall elsewhere."""
        cv2, camera = opencv(), self.camera
        fixed = np.random.default_rng([self.key, 7, step // 5])
        drops = self.weather.drops
        at = fixed.uniform((12.0, 12.0), (camera.width - 12.0, camera.height - 12.0), (drops, 2)).astype(int)
        for (u, v), r in zip(at.tolist(), fixed.integers(3, 10, drops).tolist(), strict=True):
            part = picture[v - r : v + r, u - r : u + r]
            cv2.blur(part, (2 * r - 1, 2 * r - 1), part)
        for u, v, long in draw.integers((0, 0, 6), (camera.width, camera.height - 24, 18), (drops, 3)).tolist():
            picture[v : v + long, u] = cv2.add(picture[v : v + long, u], 14)

    def _add_noise(self, picture: np.ndarray, draw: np.random.Generator) -> None:
        """Add noise to each pixel, cut from a large sheet of it at another place in each picture."""
        cv2 = opencv()
        height, width, _ = picture.shape
        if not self._noise:
            sheet = np.random.default_rng([self.key, 3]).normal(
                0.0, self.weather.noise, (height + _TILE, width + 64, 3)
            )
            self._noise["up"] = np.clip(sheet, 0.0, 255.0).round().astype(np.uint8)
            self._noise["down"] = np.clip(-sheet, 0.0, 255.0).round().astype(np.uint8)
        row, column = draw.integers(0, _TILE), draw.integers(0, 64)
        for name, change in (("up", cv2.add), ("down", cv2.subtract)):
            change(picture, self._noise[name][row : row + height, column : column + width], picture)


@cache
def _tone(weather: Weather, kind: int, share: float) -> tuple[int, int, int]:
    """Return blue, green and red of a strip, of which that share is left; the rest is road."""
    road = np.full(3, weather.asphalt)
    tone = {
        SURFACE: road,
        WHITE_PAINT: np.full(3, weather.white),
        YELLOW_PAINT: weather.white * np.array([0.25, 0.78, 1.0]),
        SEAM: 0.55 * road,
    }[kind]
    blue, green, red = (share * tone + (1.0 - share) * road).round().astype(int).tolist()
    return blue, green, red
