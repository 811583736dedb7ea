"""The kernel believes what the association by hand believes, on real traffic under attack."""

from collections import Counter
from copy import deepcopy

import numpy as np
import pytest

from gpsec.association.state import Association
from gpsec.association.tracked import associate
from gpsec.core.tables import Table
from gpsec.filters.noise import noise_of
from gpsec.reference.association import TrackAssociation
from gpsec.reference.lane_line import LaneLines
from gpsec.reference.perception import sight_of
from gpsec.types.answers import Answers
from tests.parity.drive import Drive, drive_through, record_drive


class Beliefs:
    """Implements `gpsec.types.method.Method`: both associations of every track, and nothing else."""

    def __init__(self, drive: Drive) -> None:
        ground = drive.ground
        hd_map, view = ground.hd_map, ground.world.hd_map
        self.noise, self.step_s = ground.world.noise, ground.options.step_s
        self.roads = hd_map.roads(view.layer)
        self.lines = [LaneLines(hd_map, layer) for layer in view.layer.tolist()]
        self.table = Table(Association)
        self.own: dict[int, TrackAssociation] = {}
        self._answers = Table(Answers, 1, detectors=0, defences=1)
        self.found: Counter[str] = Counter()
        self.worst_m = 0.0

    @property
    def answers(self) -> Answers:
        return self._answers.now

    def grow(self, capacity):
        self._answers.grow(capacity)
        self.table.grow(capacity)

    def reset(self, rows):
        self.table.reset(rows)
        for row in rows.tolist():
            self.own.pop(row, None)

    def copy(self, source, target):
        self.table.copy(source, target)
        for one, other in zip(source.tolist(), target.tolist(), strict=True):
            self.own[other] = deepcopy(self.own[one])

    def step(self, number, rows, tracks, vehicles, seen, threads, watch):
        state = self.table.now
        associate(rows, self.step_s, self.roads, self.noise, tracks, vehicles, seen, state)
        for row in rows.tolist():
            vehicle = int(tracks.vehicle[row])
            profile = int(vehicles.profile[vehicle])
            if row not in self.own:
                noise = noise_of(self.noise, profile)
                self.own[row] = TrackAssociation(self.lines[profile], noise, self.step_s)
            own = self.own[row]
            own.step(sight_of(row, vehicle, tracks, seen))
            best = -1 if own.best is None else own.best
            self.found["step"] += 1
            self.found["other lane"] += best != tracks.lane[row]
            self.found["otherwise known"] += own.known != tracks.lane_known[row]
            self.found["otherwise unmatched"] += own.unmatched != tracks.unmatched[row]
            self.found["unknown"] += not own.known
            self.found["several"] += len(own.hypotheses) > 1
            self.found["unmatched"] += own.unmatched
            self.found["refused"] += int(state.accepted[row] < 0)
            if best >= 0 and best == tracks.lane[row]:
                at = state.lane[row, : state.used[row]].tolist().index(best)
                off = np.abs(own.hypotheses[best].position_m - state.position_m[row, at]).max()
                self.worst_m = max(self.worst_m, float(off))


@pytest.mark.parametrize("name", ["town", "sharp_turns"])
def test_the_kernel_and_the_association_by_hand_agree(name: str) -> None:
    drive = record_drive(name, duration_s=30.0)
    beliefs = Beliefs(drive)
    drive_through(drive, 12, beliefs)
    found = beliefs.found
    assert found["step"] > 5000
    assert min(found["several"], found["refused"]) > 100
    assert (found["other lane"], found["otherwise known"], found["otherwise unmatched"]) == (0, 0, 0)
    assert beliefs.worst_m < 1e-6
