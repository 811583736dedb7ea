"""Imports an OpenDRIVE map: net, mends, check, report."""

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from gpsec.core.errors import GpsecError, shown
from gpsec.core.system import refusal
from gpsec.opendrive.check import CHECK_SPACING_M, Check, MapDeviation, check_lanes
from gpsec.opendrive.compare import match_lanes
from gpsec.opendrive.georeference import set_georeference, turn_map
from gpsec.opendrive.lanes import IMPORTED, centre_lines, check_centre_lines
from gpsec.opendrive.lefthand import map_keeps_left, mirror_map, mirror_net
from gpsec.opendrive.lengths import DIFFERS_SHARE, differing
from gpsec.opendrive.mend import describe_net, mend_net
from gpsec.opendrive.names import rename_for_netconvert, restore_names
from gpsec.opendrive.netconvert import convert_map
from gpsec.opendrive.netfile import NET_SUFFIX, NetLane, import_files, net_lanes
from gpsec.opendrive.paint import painted_lanes, sides
from gpsec.opendrive.read import parse, roads
from gpsec.opendrive.report import draw_check, write_csv
from gpsec.opendrive.reshape import SPACING_M, reshape
from gpsec.opendrive.road import Road
from gpsec.opendrive.sections import order_lanes
from gpsec.opendrive.simplify import simplify
from gpsec.opendrive.speeds import NO_LIMIT_MPS, spell_out_speeds
from gpsec.opendrive.spelling import leave_out_reversed, named, spell_out
from gpsec.opendrive.tidy import give_extent, thin_out
from gpsec.sumo.netconvert import Converted
from gpsec.types.paint import PAINT_SUFFIX, write_paint


@dataclass(frozen=True)
class Imported:
    """What an import has made.

    Attributes:
        net, csv, picture: files.
        lanes: of the net, that cars may use.
        raw: figures of what netconvert made.
        check: of the net as it is now.
        mended: what was changed against netconvert's result or for it, one sentence each.
        notes: what is as it is, and the user should know.
    """

    net: Path
    csv: Path
    picture: Path
    lanes: int
    raw: MapDeviation
    check: Check
    mended: tuple[str, ...]
    notes: tuple[str, ...]


def import_map(
    map_file: Path,
    out: Path,
    *,
    origin_deg: tuple[float, float] | None,
    alarm_m: Mapping[str, float],
    overwrite: bool,
    tell: Callable[[str], None],
) -> Imported:
    """Make a net of an OpenDRIVE map and check it against the map.

    Args:
        map_file: the map; it is not changed.
        out: the net to write, ``….net.xml``.
        origin_deg: latitude and longitude of the map's origin, None takes the map's own reference.
        alarm_m: by sensor profile, the steady residual that raises an alarm.
        overwrite: replace what is there.
        tell: is told what is being done.

    Raises:
        GpsecError: the map or a file cannot be used. Nothing is left behind then.
    """
    files = import_files(out, (NET_SUFFIX, ".check.csv", ".check.png", PAINT_SUFFIX), overwrite)
    tell("reading the map")
    root = parse(map_file)
    spelt = spell_out(root)
    map_roads = roads(root, map_file)
    turned = turn_map(root)
    if turned:
        map_roads = roads(root, map_file)
    lines = list(centre_lines(map_roads, CHECK_SPACING_M))
    if not lines:
        raise GpsecError(f"{map_file}: expected at least one lane that traffic drives on, found none")
    check_centre_lines(lines, map_file)
    lined = sides(lines, map_roads, root)
    mended = [*spelt, *([turned] if turned else []), *leave_out_reversed(map_roads)]
    mended += _prepare(root, map_roads, origin_deg)
    names = rename_for_netconvert(root)
    for written, name in list(names.items())[:1]:
        what = "names of roads and junctions that SUMO does not take, written otherwise in the net"
        mended.append(f"{what}: {len(names)}; '{shown(name)}' is '{shown(written)}' there")
    left_hand = map_keeps_left(map_roads)
    if left_hand:
        mirror_map(root)
        mended.append("traffic keeps left, which netconvert does not read: it saw the map in a mirror")
    order_lanes(root)
    try:
        with tempfile.TemporaryDirectory(prefix=".gpsec-import-", dir=out.parent) as name:
            work = Path(name)
            tell("netconvert")
            said, net = _net(root, work, map_file, left_hand)
            restore_names(net, names)
            raw = check_lanes(lines, net_lanes(net), alarm_m).overall
            tell("giving lanes their shapes")
            reshaped = reshape(net, list(centre_lines(map_roads, SPACING_M, IMPORTED)))
            mended += mend_net(net)
            mended.append(f"lanes with the map's own centre line instead of netconvert's: {reshaped.lanes}")
            tell("checking")
            lanes = net_lanes(net)
            check = check_lanes(lines, lanes, alarm_m)
            notes = [*_notes(said, map_roads, left_hand, reshaped.left_alone), *describe_net(net)]
            notes += _faults(check, lanes)
            tell("writing")
            made = [work / f"made{suffix}" for suffix in (NET_SUFFIX, ".csv", ".png", PAINT_SUFFIX)]
            ElementTree.indent(net, "    ")
            ElementTree.ElementTree(net).write(made[0], encoding="utf-8", xml_declaration=True)
            write_csv(check, made[1])
            draw_check(check, made[2], f"{map_file.stem}: {len(lanes)} lanes")
            write_paint(painted_lanes(match_lanes(lines, lanes), *lined, lanes), made[3])
            for path, target in zip(reversed(made), reversed(files), strict=True):
                path.replace(target)
    except OSError as error:
        raise refusal(error, f"{out}: cannot be written") from None
    net_file, table, picture, _ = files
    return Imported(net_file, table, picture, len(lanes), raw, check, tuple(mended), tuple(notes))


def _prepare(root: Element, map_roads: list[Road], origin_deg: tuple[float, float] | None) -> list[str]:
    """Mend the map before netconvert sees it; return what was done."""
    speeds = spell_out_speeds(map_roads)
    said = [
        (speeds.from_road, "limits of roads, which netconvert does not read, given to lanes"),
        (speeds.not_positive, "limits of 0 or less, left out"),
        (speeds.unlimited, f"limits that say there is none, taken for {NO_LIMIT_MPS * 3.6:.0f} km/h"),
    ]
    mended = [f"speed {what}: {count}" for count, what in said if count]
    mended += simplify(root)
    reference = set_georeference(root, origin_deg)
    return [*mended, *([reference] if reference else [])]


def _net(root: Element, work: Path, map_file: Path, left_hand: bool) -> tuple[Converted, Element]:
    """Run netconvert; return what it said, and the net.

    Raises:
        GpsecError: it refuses the map, or makes a net without a lane for cars.
    """
    source, target = work / "map.xodr", work / f"raw{NET_SUFFIX}"
    ElementTree.ElementTree(root).write(source, encoding="utf-8", xml_declaration=True)
    said = convert_map(source, target, map_file)
    net = ElementTree.fromstring(thin_out(give_extent(target.read_text(encoding="utf-8"))).encode())
    if left_hand:
        mirror_net(net)
    if not any(not lane.internal for lane in net_lanes(net)):
        raise GpsecError(f"{map_file}: netconvert makes a net of it that has no lane for cars")
    return said, net


def _faults(check: Check, lanes: list[NetLane]) -> list[str]:
    said = [
        named("lanes of the map that the net has not, or less than half of", check.lost),
        named(f"lanes whose shape and length differ by more than {DIFFERS_SHARE:.0%}", differing(lanes)),
    ]
    return [sentence for sentence in said if sentence]


def _notes(said: Converted, map_roads: list[Road], left_hand: bool, left_alone: int) -> list[str]:
    notes = said.notes()
    if others := sum(road.left_hand != left_hand for road in map_roads):
        notes.append(f"roads that keep to the other side than most, where a net has one side: {others}")
    if left_alone:
        notes.append(f"lanes of netconvert's shape outside junctions, since SUMO's junctions cover them: {left_alone}")
    return notes
