"""By how much the image channel errs: rendered views of vehicles in traffic, in one weather after the other."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely

from gpsec.core.arrays import Flags, Floats, Longs
from gpsec.core.errors import GpsecError
from gpsec.core.npz import DamagedError, read_npz
from gpsec.core.system import in_a_sentence
from gpsec.imaging.filming.film import Film
from gpsec.imaging.pictures.lanes import LaneFinder
from gpsec.imaging.pictures.memory import LaneMemory
from gpsec.imaging.pictures.mounting import camera_on, misaligned
from gpsec.imaging.pictures.paint import paint_roads
from gpsec.imaging.pictures.render import Renderer
from gpsec.imaging.pictures.strips import Painted
from gpsec.imaging.pictures.weather import WEATHERS

# A vehicle that is on the road for less is not worth its pictures.
_LEAST_S = 10.0


class Errors(NamedTuple):
    """What was measured of one vehicle in one weather; n pictures of a lane that could be seen.

    Attributes:
        moment: (n,) number of the moment of each.
        single, kept: (n, 4) errors of C0 … C3 by one picture, and with memory; 0 where nothing was found.
        single_sigma_m, kept_sigma_m: (n,) stated; 0 where nothing was found.
        found: (n,) a lane was found.
        clear_m: (n,) distance of the rear axle from the next junction.
    """

    moment: Longs
    single: Floats
    kept: Floats
    single_sigma_m: Floats
    kept_sigma_m: Floats
    found: Flags
    clear_m: Floats


@dataclass(frozen=True)
class Campaign:
    """What is measured, and where what is done so far lies.

    Attributes:
        film: the traffic.
        scenario: all that it depends on, as text.
        error_deg: standard deviation of how cameras are mounted, on each axis, unknown to them.
        folder: of the results.
    """

    film: Film
    scenario: str
    error_deg: float
    folder: Path

    def vehicles(self, count: int) -> list[int]:
        """Return so many vehicles, by the hash of their names, of those that are long enough on marked roads.

        Raises:
            GpsecError: there are none.
        """
        film = self.film
        marked = np.bincount(film.vehicle[film.marked], minlength=len(film.names))
        able = np.flatnonzero(marked * film.step_s >= _LEAST_S)
        if not len(able):
            raise GpsecError(f"expected a vehicle on marked roads for {_LEAST_S:g} s, found none: a later --to")
        order = np.argsort(film.key[able])
        chosen: list[int] = able[order][:count].tolist()
        return chosen

    def measure(self, weather: str, vehicles: Sequence[int], tell: Callable[[int, int], None]) -> list[Errors]:
        """Return the errors of each vehicle in a weather; what was measured before is read again."""
        ground: Painted | None = None
        found = []
        for number, vehicle in enumerate(vehicles, start=1):
            path = self.folder / "parts" / f"{self._mark(weather, vehicle)}.npz"
            errors = _read(path)
            if errors is None:
                ground = ground or paint_roads(self.film.hd_map, 0)
                errors = self._drive(weather, vehicle, ground)
                _write(errors, path)
            found.append(errors)
            tell(number, len(vehicles))
        return found

    def _mark(self, weather: str, vehicle: int) -> str:
        """Return the name of a part, by all that it depends on."""
        said = json.dumps([self.scenario, repr(WEATHERS[weather]), self.film.names[vehicle], self.error_deg])
        times = f"{self.film.time_s[0]} {self.film.time_s[-1]} {self.film.step_s}"
        return f"{weather}-{hashlib.sha256((said + times).encode()).hexdigest()[:16]}"

    def _drive(self, weather: str, vehicle: int, ground: Painted) -> Errors:
        film = self.film
        camera, key = camera_on(float(film.axle_m[vehicle])), int(film.key[vehicle])
        renderer = Renderer(misaligned(camera, key, self.error_deg), ground, WEATHERS[weather], key)
        finder, memory = LaneFinder(camera), LaneMemory()
        rows = np.flatnonzero((film.vehicle == vehicle) & film.marked)
        moment = np.array([film.moment_of(row) for row in rows.tolist()])
        single, kept = np.zeros((2, len(rows), 4))
        sigma = np.zeros((2, len(rows)))
        last = -2
        for at, row in enumerate(rows.tolist()):
            width_m = float(film.hd_map.sides.width_m[film.lane[row]])
            seen = finder.find(renderer.picture(film.moment(row)), width_m)
            follows = moment[at] == last + 1
            way = (float(film.speed_mps[row]) * film.step_s, float(film.yaw_rate_rps[row]) * film.step_s)
            longer = memory.take(seen, way if follows else None)
            last = int(moment[at])
            if seen.valid:
                single[at], kept[at] = seen.poly - film.truth[row], longer.poly - film.truth[row]
                sigma[:, at] = seen.sigma_m, longer.sigma_m
        return Errors(moment, single, kept, sigma[0], sigma[1], sigma[0] > 0.0, self._clear_m(film.rear_m[rows]))

    def _clear_m(self, places_m: Floats) -> Floats:
        """Return the distance of (n, 2) places from the nearest lane inside a junction."""
        hd_map = self.film.hd_map
        inside = [shapely.LineString(hd_map.centre_line(int(lane))) for lane in np.flatnonzero(hd_map.sides.internal)]
        if not inside:
            return np.full(len(places_m), 1e6)
        tree = shapely.STRtree(inside)
        _, away = tree.query_nearest(shapely.points(places_m), return_distance=True, all_matches=False)
        return np.asarray(away, np.float64)


def _write(errors: Errors, path: Path) -> None:
    with in_a_sentence(f"{path}: what was measured cannot be written there"):
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".tmp")
        with part.open("wb") as stream:
            np.savez_compressed(stream, **errors._asdict())
        part.replace(path)


def _read(path: Path) -> Errors | None:
    """Return what was measured before, None where that is not there or damaged."""
    try:
        with path.open("rb") as stream:
            found = read_npz(stream)
        return Errors(**found)
    except (OSError, DamagedError, TypeError):
        return None
