"""Writes which lanes of a network have lines beside them, from the road marks of its OpenDRIVE file."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

from gpsec.opendrive.check import CHECK_SPACING_M
from gpsec.opendrive.compare import match_lanes
from gpsec.opendrive.lanes import centre_lines
from gpsec.opendrive.netfile import NetLane, net_lanes
from gpsec.opendrive.paint import painted_lanes, sides
from gpsec.opendrive.read import parse, roads
from gpsec.types.paint import paint_file, write_paint
from sumo_nets.convert import netconvert
from sumo_nets.plan import Plan


def write_lines(plan: Plan, source: Path, net: Path) -> None:
    """Write `NAME.paint.csv` beside a network that was made of `source`."""
    root = parse(source)
    map_roads = roads(root, source)
    lines = list(centre_lines(map_roads, CHECK_SPACING_M))
    lanes = _named_lanes(plan, source)
    write_paint(painted_lanes(match_lanes(lines, lanes), *sides(lines, map_roads, root), lanes), paint_file(net))


def _named_lanes(plan: Plan, source: Path) -> list[NetLane]:
    """Return the lanes of the network, which itself has no names of the map's lanes, with them."""
    with tempfile.TemporaryDirectory() as folder:
        net = Path(folder) / "named.net.xml"
        netconvert(replace(plan, netconvert=(*plan.netconvert, "--output.original-names")), source, net)
        return net_lanes(ElementTree.parse(net).getroot())
