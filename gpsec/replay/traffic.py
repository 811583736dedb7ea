"""Traffic that SUMO wrote down as FCD, in the place of SUMO."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError
from gpsec.core.geo import Projector, yaw_from_sumo_angle
from gpsec.core.tables import Slots
from gpsec.hdmap.net import read_net
from gpsec.pipeline.interfaces import StartTraffic
from gpsec.replay.fcd import Seen, read_clock, steps
from gpsec.replay.logged import LENGTH_M, WIDTH_M
from gpsec.replay.prepare import LogOrder
from gpsec.traffic.names import VehicleNames
from gpsec.traffic.offline import OfflineTraffic
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.source import Departure, Equip, Frame

# A move may be this much longer than the speed allows before it counts as a jump.
_JUMP_MARGIN_M = 1.0
_SAME_STEP = 1e-3


class FcdTraffic(OfflineTraffic):
    """The vehicles of an FCD file; one that jumps goes on as another, `id#2`, as with SUMO itself."""

    def __init__(self, log: Path, options: SumoOptions, lane_index: Mapping[str, int], equip: Equip) -> None:
        super().__init__(options)
        self._log = log
        self._clock = read_clock(log)
        self.step_s = self._clock.step_s
        self._lane_index = lane_index
        self._equip = equip
        self._projector: Projector | None = None
        self._names = VehicleNames()
        self._slots = Slots()
        self._row: dict[str, int] = {}
        self._front_m: dict[str, Floats] = {}
        self._speed_mps: dict[str, float] = {}
        self._refused: set[str] = set()

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        """Yield the steps, all or those of `duration_s`.

        Raises:
            GpsecError: time runs backwards, steps are missing, or the file is broken.
        """
        before_s: float | None = None
        number = 0
        for time_s, seen in steps(self._log):
            if before_s is not None and abs(time_s - before_s - self.step_s) > _SAME_STEP:
                what = "time runs backwards" if time_s <= before_s else "steps are missing"
                raise GpsecError(
                    f"{self._log}: {what}: expected the step {before_s + self.step_s:g} s, found {time_s:g} s"
                )
            before_s = time_s
            if time_s <= self.options.begin_s + 0.5 * _SAME_STEP:
                continue  # a step ends later than it begins
            if duration_s is not None and number * self.step_s >= duration_s - _SAME_STEP * self.step_s:
                return
            yield self._frame(number, time_s, seen)
            number += 1

    def _frame(self, number: int, time_s: float, seen: list[Seen]) -> Frame:
        on_map = [one for one in seen if one.lane in self._lane_index]
        front_m = self._metres(on_map)
        present = {one.vehicle_id for one in on_map}
        left = [self._leave(name) for name in [name for name in self._row if name not in present]]
        departures = []
        for one, place in zip(on_map, front_m, strict=True):
            name = one.vehicle_id
            if name in self._row and self._jumps(one, place):
                left.append(self._leave(name))
            if name not in self._row and (entered := self._enter(one)) is not None:
                departures.append(entered)
            self._front_m[name], self._speed_mps[name] = place, one.speed_mps
        kept = [(self._row[one.vehicle_id], at) for at, one in enumerate(on_map) if one.vehicle_id in self._row]
        kept.sort()
        order = [at for _, at in kept]
        self._refused &= {one.vehicle_id for one in seen}
        return Frame(
            step=number,
            time_s=time_s,
            left=left,
            departures=departures,
            rows=np.array([row for row, _ in kept], np.int32),
            front_m=front_m[order],
            lane=np.array([self._lane_index[on_map[at].lane] for at in order], np.int32),
            on_road=len(seen),
        )

    def _jumps(self, one: Seen, place: Floats) -> bool:
        moved_m = float(np.hypot(*(place - self._front_m[one.vehicle_id])))
        fastest_mps = max(one.speed_mps, self._speed_mps[one.vehicle_id])
        return moved_m > fastest_mps * self.step_s + _JUMP_MARGIN_M

    def _leave(self, name: str) -> int:
        row = self._row.pop(name)
        self._slots.give_back(row)
        return row

    def _enter(self, one: Seen) -> Departure | None:
        """Return the departure of a vehicle that takes part, None where it does not."""
        if one.vehicle_id in self._refused:
            return None
        if not self._equip(self._departure(one, one.vehicle_id, -1)):
            self._refused.add(one.vehicle_id)
            return None
        row = self._slots.take()
        self._row[one.vehicle_id] = row
        return self._departure(one, self._names.give(one.vehicle_id), row)

    def _departure(self, one: Seen, name: str, row: int) -> Departure:
        return Departure(
            row=row,
            vehicle_id=name,
            vehicle_type=one.kind,
            vehicle_class="passenger",
            length_m=LENGTH_M,
            width_m=WIDTH_M,
            yaw_rad=yaw_from_sumo_angle(one.angle_deg),
            speed_mps=one.speed_mps,
            equipped_share=None,
            sensors=None,
            sumo_id=one.vehicle_id,
        )

    def _metres(self, seen: list[Seen]) -> Floats:
        """Return the (n, 2) fronts in the net's frame; with SUMO's option fcd-output.geo they are degrees."""
        places = np.array([(one.x, one.y) for one in seen], float).reshape(-1, 2)
        if self._projector is None and len(places):
            self._projector = self._frame_of(places)
        if self._projector is None or not self._projector.has_projection:
            return places
        return self._projector.from_lon_lat(places)

    def _frame_of(self, places: Floats) -> Projector:
        """Return what makes metres of positions: of a net without a projection where they are metres already."""
        known = read_net(self.options.net_file)
        corners = np.concatenate([lane.shape_m for lane in known.lanes])
        low, high = corners.min(axis=0) - 100.0, corners.max(axis=0) + 100.0
        if ((places >= low) & (places <= high)).all():
            return Projector("!")
        degrees = (np.abs(places) <= np.array([180.0, 90.0])).all()
        if known.projector.has_projection and degrees:
            moved = known.projector.from_lon_lat(places)
            if ((moved >= low) & (moved <= high)).all():
                return known.projector
        raise GpsecError(
            f"{self._log}: expected positions within the net {self.options.net_file}, found"
            f" ({places[0, 0]:g}, {places[0, 1]:g}): it is another net's"
        )


def fcd_traffic(order: LogOrder) -> StartTraffic:
    """Return what starts the traffic of an order."""

    def start(options: SumoOptions, lane_index: Mapping[str, int], equip: Equip) -> FcdTraffic:
        return FcdTraffic(Path(order.log), options, lane_index, equip)

    return start
