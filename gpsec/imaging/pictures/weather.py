"""Light, rain and wear: what stands between the paint and the pixels.

The figures are assumed, and none was fitted to an error of the lane.
"""

from dataclasses import dataclass

from gpsec.core.errors import GpsecError, nearest, shown


@dataclass(frozen=True)
class Weather:
    """What a picture is taken in; grey levels are of 255.

    Attributes:
        sky, asphalt, verge, white: grey levels in daylight.
        worn: share of its strength that the most worn paint has lost, the least worn quarter nothing; over 1, some of
            it is gone.
        daylight: share of it that there is.
        headlights: brightness of one's own beams on the road, as a share of daylight.
        shadows: trees throw some.
        wet: share of the sky that the road mirrors.
        drops: on the windscreen in a picture.
        noise: standard deviation of a pixel.
        blur_px: standard deviation of the blur of lens and spray.
    """

    sky: int = 215
    asphalt: int = 92
    verge: int = 105
    white: int = 215
    worn: float = 0.25
    daylight: float = 1.0
    headlights: float = 0.0
    shadows: bool = False
    wet: float = 0.0
    drops: int = 0
    noise: float = 3.0
    blur_px: float = 0.6


WEATHERS = {
    "good": Weather(),
    "noiseless": Weather(worn=0.0, noise=0.0, blur_px=0.0),
    "shadows": Weather(shadows=True),
    "worn": Weather(worn=1.9),
    "night": Weather(daylight=0.06, headlights=0.75, noise=6.0),
    "rain": Weather(daylight=0.55, wet=0.3, drops=40, noise=5.0, blur_px=1.2),
    "rain-night": Weather(daylight=0.04, headlights=0.5, wet=0.35, drops=50, noise=8.0, blur_px=1.3),
}
"""Name -> weather."""


def weather_of(name: str) -> Weather:
    """Return the weather of that name.

    Raises:
        GpsecError: there is none.
    """
    if name not in WEATHERS:
        raise GpsecError(f"--weather: unknown weather '{shown(name)}'; {nearest(name, WEATHERS)}")
    return WEATHERS[name]
