"""Imports an extract of OpenStreetMap as a net of the roads that cars may use."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from gpsec.core.errors import GpsecError
from gpsec.core.system import refusal
from gpsec.opendrive.mend import describe_net, mend_net
from gpsec.opendrive.netfile import NET_SUFFIX, import_files, net_lanes
from gpsec.opendrive.polylines import stations
from gpsec.opendrive.tidy import give_extent, thin_out
from gpsec.openstreetmap.extract import read_extract, unpack
from gpsec.openstreetmap.side import extract_keeps_left
from gpsec.sumo.home import sumo_home
from gpsec.sumo.netconvert import convert

# What OpenStreetMap draws is the middle of a road; the types say how many lanes it has, and how fast they are.
_TYPES = "data/typemap/osmNetconvert.typ.xml"
OSM_OPTIONS = (
    "--precision=4",
    "--precision.geo=8",
    "--keep-edges.by-vclass=passenger",
    "--ramps.guess",
    "--tls.guess-signals",
    "--tls.discard-simple",
    "--no-turnarounds",
    "--junctions.corner-detail=5",
    "--junctions.limit-turn-speed=3.5",
    "--output.street-names",
    "--output.original-names",
)
DISPENSABLE = (
    "--geometry.remove",
    "--junctions.join",
    "--tls.join",
    "--tls.default-type=actuated",
    "--osm.turn-lanes",
)


@dataclass(frozen=True)
class ImportedExtract:
    """What an import has made.

    Attributes:
        net_file: the net.
        lanes: of the net, outside junctions, that cars may use.
        length_m: of these lanes.
        mended: what was changed against netconvert's result or for it, one sentence each.
        notes: what is as it is, and the user should know.
    """

    net_file: Path
    lanes: int
    length_m: float
    mended: tuple[str, ...]
    notes: tuple[str, ...]


def import_extract(
    map_file: Path, out: Path, *, left_hand: bool | None, overwrite: bool, tell: Callable[[str], None]
) -> ImportedExtract:
    """Make a net of an extract of OpenStreetMap.

    Args:
        map_file: XML, compressed by gzip or bzip2 or not; it is not changed.
        out: the net to write, ``….net.xml``.
        left_hand: traffic keeps left; None finds out.
        overwrite: replace what is there.
        tell: is told what is being done.

    Raises:
        GpsecError: the extract or a file cannot be used. Nothing is left behind then.
        MachineError: netconvert takes more time or memory than it may have, or crashes.
    """
    (target,) = import_files(out, (NET_SUFFIX,), overwrite)
    try:
        with tempfile.TemporaryDirectory(prefix=".gpsec-import-", dir=out.parent) as name:
            work = Path(name)
            tell("reading the extract")
            source, raw = work / "map.osm", work / f"raw{NET_SUFFIX}"
            unpack(map_file, source)
            left, why = extract_keeps_left(read_extract(source, map_file))
            side = "traffic keeps " + ("left" if left else "right") + f", {why}"
            if left_hand is not None:
                left, side = left_hand, f"traffic keeps {'left' if left_hand else 'right'}, as you say"
            tell("netconvert")
            types = f"--type-files={sumo_home() / _TYPES}"
            options = [f"--osm-files={source.name}", types, *OSM_OPTIONS, *(["--lefthand"] if left else [])]
            said = convert(options, DISPENSABLE, raw, map_file)
            net = ElementTree.fromstring(thin_out(give_extent(raw.read_text(encoding="utf-8"))).encode())
            lanes = [lane for lane in net_lanes(net) if not lane.internal]
            if not lanes:
                raise GpsecError(f"{map_file}: netconvert makes a net of it that has no lane for cars")
            mended = mend_net(net)
            tell("writing")
            made = work / f"made{NET_SUFFIX}"
            ElementTree.indent(net, "    ")
            ElementTree.ElementTree(net).write(made, encoding="utf-8", xml_declaration=True)
            notes = [side, *said.notes(), *describe_net(net)]
            made.replace(target)
    except OSError as error:
        raise refusal(error, f"{out}: cannot be written") from None
    length_m = sum(float(stations(lane.points_m)[-1]) for lane in lanes)
    return ImportedExtract(target, len(lanes), length_m, tuple(mended), tuple(notes))
