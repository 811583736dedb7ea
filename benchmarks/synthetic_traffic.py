"""Recorded traffic with fewer or more vehicles, in SUMO's place.

``python -m benchmarks.synthetic_traffic SUMOCFG SECONDS FILE`` makes a recording.
"""

import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from gpsec.traffic.offline import OfflineTraffic
from gpsec.traffic.options import SumoOptions, resolve_options
from gpsec.traffic.recording import RecordedTraffic, Recording, record_traffic
from gpsec.traffic.source import Departure, Equip, Frame


class SyntheticTraffic(OfflineTraffic):
    """A recording of N vehicles as traffic of any number; implements `gpsec.pipeline.interfaces.Traffic`.

    Vehicles of the lowest rows are taken, as often as it needs to reach the number, under other ids: with other
    sensor noise, and attacks at other times. Few of the recording's vehicles are memory of the run.

    Attributes:
        step_s: length of a step.

    """

    def __init__(
        self, recording: Recording, count: int, options: SumoOptions, lane_index: Mapping[str, int], equip: Equip
    ) -> None:
        """Take `count` vehicles at once; `lane_index` and `equip` were asked when the recording was made."""
        super().__init__(options)
        at_once = int(recording.start[1])
        self._copies = -(-count // at_once)
        self._kept = count // self._copies
        self._source = RecordedTraffic(recording)
        self.step_s = self._source.step_s

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        """Yield the frames of this traffic."""
        for frame in self._source.frames(duration_s):
            before = perf_counter()
            several = self._multiplied(frame)
            self.read_s += perf_counter() - before
            yield several

    def _multiplied(self, frame: Frame) -> Frame:
        kept = frame.rows < self._kept
        shifts = [copy * self._kept for copy in range(self._copies)]
        rows = np.concatenate([frame.rows[kept] + np.int32(shift) for shift in shifts])
        return replace(
            frame,
            left=[row + shift for shift in shifts for row in frame.left if row < self._kept],
            departures=[_copy(who, shift) for shift in shifts for who in frame.departures if who.row < self._kept],
            rows=rows,
            front_m=np.tile(frame.front_m[kept], (self._copies, 1)),
            lane=np.tile(frame.lane[kept], self._copies),
            on_road=len(rows),
        )


def _copy(departure: Departure, shift: int) -> Departure:
    return replace(departure, row=departure.row + shift, vehicle_id=f"{shift}~{departure.vehicle_id}")


def everybody(departure: Departure) -> bool:
    """Equip every vehicle."""
    return True


def main() -> None:
    """Record the traffic of a configuration."""
    # SUMO's process does not import the main module, so that a function of it cannot be sent there.
    from benchmarks import synthetic_traffic
    from gpsec.hdmap.map import load_map
    from gpsec.traffic.recordingfile import on_net, save_recording
    from gpsec.traffic.remote import RemoteSession

    sumocfg, seconds, target = sys.argv[1:]
    options = resolve_options(Path(sumocfg), seed=1)
    hd_map = load_map(options.net_file, ())
    with RemoteSession(options, hd_map.lane_index, synthetic_traffic.everybody) as session:
        recording = record_traffic(session, float(seconds))
    save_recording(recording, Path(target), on_net(options.net_file, len(hd_map.lane_ids)))


if __name__ == "__main__":
    main()
