"""The compiled map of the real nets against sumolib and shapely."""

from functools import cached_property
from typing import Any

import numpy as np
import pytest
import shapely
import sumolib

from gpsec.hdmap.index import REACH_M

from .drive import Drive


class PlainNet:
    """A net as sumolib reads it."""

    def __init__(self, file: str) -> None:
        net = sumolib.net.readNet(file, withInternal=True)
        self._lanes = {lane.getID(): lane for edge in net.getEdges(True) for lane in edge.getLanes()}

    def line(self, lane: str) -> shapely.LineString:
        """Every lane, also one that is only a point."""
        return shapely.LineString(self._lanes[lane].getShape())

    @cached_property
    def after(self) -> dict[str, set[str]]:
        return {name: {_next(outgoing) for outgoing in lane.getOutgoing()} for name, lane in self._lanes.items()}

    @cached_property
    def before(self) -> dict[str, set[str]]:
        links: dict[str, set[str]] = {name: set() for name in self._lanes}
        for name, following in self.after.items():
            for other in following:
                links[other].add(name)
        return links

    def within_reach(self, lane: str, links: dict[str, set[str]]) -> set[str]:
        """Lanes that begin within reach of the end of `lane`, by relaxing distances until none changes."""
        distance = dict.fromkeys(links[lane], 0.0)
        changed = True
        while changed:
            changed = False
            for name, way_m in list(distance.items()):
                beyond_m = way_m + self.line(name).length
                for other in links[name]:
                    if beyond_m <= REACH_M and beyond_m < distance.get(other, np.inf):
                        distance[other] = beyond_m
                        changed = True
        return set(distance)


def _next(connection: Any) -> str:
    return connection.getViaLaneID() or connection.getToLane().getID()


@pytest.fixture(scope="session")
def plain(drive: Drive) -> PlainNet:
    return PlainNet(str(drive.ground.options.net_file))


def test_chains_are_what_sumolib_says_leads_to_a_lane_and_on_from_it(drive: Drive, plain: PlainNet):
    hd_map = drive.ground.hd_map
    index, names = hd_map.index, hd_map.lane_ids
    for lane in range(0, len(names), 3):
        run = slice(index.chain_first[lane], index.chain_first[lane] + index.chain_count[lane])
        chain = {names[other] for other in index.chain_lane[run]}
        name = names[lane]
        expected = {name} | plain.within_reach(name, plain.after) | plain.within_reach(name, plain.before)
        assert chain == {other for other in expected if plain.line(other).length > 0.0}


def test_lane_ends_are_open_where_sumolib_knows_no_connection(drive: Drive, plain: PlainNet):
    lanes = drive.ground.hd_map.lanes
    ends = 0
    for lane, name in enumerate(drive.ground.hd_map.lane_ids):
        for layer in range(len(lanes.first)):
            first = lanes.first[layer, lane]
            run = slice(first, first + lanes.segments[layer, lane])
            assert lanes.open_start[run].tolist() == [not plain.before[name]] + [False] * (run.stop - first - 1)
            assert lanes.open_end[run].tolist() == [False] * (run.stop - first - 1) + [not plain.after[name]]
            ends += not plain.before[name]
    assert ends > 0


def test_layers_hold_points_at_equal_distances_on_the_true_line(drive: Drive, plain: PlainNet):
    hd_map = drive.ground.hd_map
    for lane in range(0, len(hd_map.lane_ids), 3):
        line = plain.line(hd_map.lane_ids[lane])
        assert shapely.hausdorff_distance(shapely.LineString(hd_map.centre_line(lane)), line) < 1e-9
        for spacing_m in hd_map.spacings_m:
            points = hd_map.centre_line(lane, hd_map.layer(spacing_m))
            pieces = len(points) - 1
            # As few as keep the spacing.
            assert line.length / pieces <= spacing_m * (1.0 + 1e-9)
            assert pieces == 1 or line.length / (pieces - 1) > spacing_m * (1.0 - 1e-9)
            expected = shapely.line_interpolate_point(line, np.linspace(0.0, 1.0, pieces + 1), normalized=True)
            assert np.abs(points - shapely.get_coordinates(expected)).max() < 1e-9
