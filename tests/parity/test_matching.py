"""Matching against shapely, far more often and further off the matcher than one drive under attack does it."""

import numpy as np
import pytest

from gpsec.core.arrays import Floats, Ints
from gpsec.hdmap.matching import MatchedOffsets, offsets
from gpsec.hdmap.search import NEAREST, TRACKED
from gpsec.reference.matching import LaneMatcher

from .drive import Drive

# A position may be nearest to a point that two lanes share: then rounding decides which of them it is matched to.
SHARED_END_M = 1e-9


@pytest.fixture(scope="session")
def places(drive: Drive) -> tuple[Floats, Floats, Ints]:
    """Positions of real vehicles, their course, and their lane, each moved by 0.05 to 15 m of error."""
    recording = drive.recording
    last: dict[int, Floats] = {}
    found: list[tuple[Floats, float, int]] = []
    for number in range(len(recording)):
        frame = recording.frame(number)
        for row in [*frame.left, *(departure.row for departure in frame.departures)]:
            last.pop(row, None)
        for row, front_m, lane in zip(frame.rows.tolist(), frame.front_m, frame.lane.tolist(), strict=True):
            step = front_m - last.get(row, front_m)
            if np.hypot(*step) > 0.05:
                found.append((front_m, float(np.arctan2(step[1], step[0])), lane))
            last[row] = front_m
    generator = np.random.default_rng(5)
    chosen = [found[at] for at in generator.permutation(len(found))[:3000]]
    error_m = generator.normal(size=(len(chosen), 2)) * np.resize([0.05, 0.5, 3.0, 15.0], len(chosen))[:, None]
    position = np.array([place[0] for place in chosen]) + error_m
    return position, np.array([place[1] for place in chosen]), np.array([place[2] for place in chosen], np.int32)


@pytest.mark.parametrize("mode", [TRACKED, NEAREST])
def test_offsets_with_their_signs_on_every_layer(drive: Drive, places: tuple[Floats, Floats, Ints], mode: int):
    position, heading, lane = places
    hd_map = drive.ground.hd_map
    left = right = against = 0
    for layer in range(1 + len(hd_map.spacings_m)):
        segment, offset = np.zeros(len(lane), np.int32), np.zeros(len(lane))
        offsets(hd_map.lanes, hd_map.index, mode, layer, lane, position, heading, MatchedOffsets(segment, offset))
        matcher = LaneMatcher(hd_map, layer, mode == TRACKED)
        between = 0
        for i, (x, y) in enumerate(position.tolist()):
            expected = matcher.offset(x, y, float(heading[i]), int(lane[i]))
            found = float(offset[i]) if segment[i] >= 0 else None
            both = expected is not None and found is not None
            if abs(expected - found) > 1e-9 if both else expected is not found:
                assert _shares_an_end(drive, layer, int(segment[i]), position[i])
                between += 1
        assert between <= 1
        matched = segment >= 0
        assert matched.mean() > 0.95
        left, right = left + int((offset[matched] > 0.1).sum()), right + int((offset[matched] < -0.1).sum())
        course = hd_map.lanes.yaw0_rad[segment[matched]]
        against += int((np.cos(course - heading[matched]) < 0.0).sum())
    assert min(left, right) > 1000
    assert against == 0


def _shares_an_end(drive: Drive, layer: int, segment: int, position: Floats) -> bool:
    """Whether there is a `segment`, and its point that is nearest to a position is an end of its lane."""
    if segment < 0:
        return False
    hd_map = drive.ground.hd_map
    line = hd_map.centre_line(int(hd_map.lanes.lane[segment]), layer)
    at = segment - hd_map.lanes.first[layer, hd_map.lanes.lane[segment]]
    start, step = line[at], line[at + 1] - line[at]
    share = float(np.clip((position - start) @ step / (step @ step), 0.0, 1.0))
    nearest = start + share * step
    return min(np.hypot(*(nearest - line[0])), np.hypot(*(nearest - line[-1]))) < SHARED_END_M
