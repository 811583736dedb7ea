"""Reads an extract of OpenStreetMap: number of roads, centre, directions of roundabouts."""

import bz2
import gzip
import zlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import cos, isfinite, radians
from pathlib import Path
from typing import BinaryIO
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from gpsec.core.errors import GpsecError, shown
from gpsec.core.system import refusal

# More than netconvert has memory for, and little enough for a disk.
MOST_BYTES = 4 << 30
_PIECE_BYTES = 1 << 20
_NAMES = (".osm", ".osm.xml", ".osm.gz", ".osm.bz2", ".pbf")
_BROKEN = (EOFError, zlib.error, ElementTree.ParseError, LookupError, ValueError)


@dataclass(frozen=True)
class Extract:
    """What an import needs to know of an extract.

    Attributes:
        roads: ways with a tag `highway`.
        centre_deg: mean latitude and longitude of its nodes.
        clockwise, counterclockwise: roundabouts, by the direction in which they are driven.
    """

    roads: int
    centre_deg: tuple[float, float]
    clockwise: int
    counterclockwise: int


def is_extract(map_file: Path) -> bool:
    """Return whether a file is one of OpenStreetMap, by its name or its content."""
    if map_file.name.endswith(_NAMES):
        return True
    with suppress(OSError, *_BROKEN), _opened(map_file) as stream:
        _, root = next(ElementTree.iterparse(stream, ("start",)))
        return bool(root.tag == "osm")
    return False


def unpack(map_file: Path, target: Path) -> None:
    """Write an extract, compressed by gzip or bzip2 or not, into a file that netconvert can read.

    Raises:
        GpsecError: it cannot be read, is damaged, too large, or in the PBF format.
        MachineError: the disk is full.
    """
    if map_file.suffix == ".pbf":
        raise GpsecError(
            f"{map_file}: expected OpenStreetMap data as XML, found the PBF format; "
            f"`osmium cat {map_file.name} -o {map_file.name.removesuffix('.pbf').removesuffix('.osm')}.osm` converts it"
        )
    try:
        with target.open("wb") as written, _opened(map_file) as stream:
            while piece := stream.read(_PIECE_BYTES):
                written.write(piece)
                if written.tell() > MOST_BYTES:
                    raise GpsecError(f"{map_file}: expected at most {MOST_BYTES / 2**30:g} GiB of XML; cut a piece out")
    except (EOFError, zlib.error) as error:
        raise _damaged(map_file, error) from None
    except OSError as error:
        if error.errno is None:  # what was read, not how
            raise _damaged(map_file, error) from None
        raise refusal(error, f"{map_file}: cannot be unpacked") from None


def _damaged(map_file: Path, error: Exception) -> GpsecError:
    return GpsecError(f"{map_file}: expected compressed data, found it damaged ({error})")


def _opened(map_file: Path) -> BinaryIO:
    """Return a stream of the uncompressed content of a file."""
    with map_file.open("rb") as stream:
        magic = stream.read(3)
    if magic[:2] == b"\x1f\x8b":
        return gzip.open(map_file, "rb")  # type: ignore[return-value]
    return bz2.open(map_file, "rb") if magic == b"BZh" else map_file.open("rb")  # type: ignore[return-value]


def read_extract(osm_file: Path, map_file: Path) -> Extract:
    """Return what an import needs to know of an extract; error messages name `map_file`.

    Raises:
        GpsecError: it is no XML, not OpenStreetMap, or has no road.
    """
    try:
        return _read(osm_file, map_file)
    except _BROKEN as error:
        raise GpsecError(f"{map_file}: expected OpenStreetMap data, found no XML that can be read ({error})") from None


def _read(osm_file: Path, map_file: Path) -> Extract:
    roads, rings = 0, []
    for way in _elements(osm_file, map_file, "way"):
        tags = {tag.get("k"): tag.get("v") for tag in way.iterfind("tag")}
        roads += "highway" in tags
        if "highway" in tags and tags.get("junction") == "roundabout":
            rings.append([node.get("ref", "") for node in way.iterfind("nd")])
    wanted = {node for ring in rings for node in ring}
    points: dict[str, tuple[float, float]] = {}
    count, total_lat, total_lon = 0, 0.0, 0.0
    for node in _elements(osm_file, map_file, "node"):
        place = _place(node)
        if place is not None:
            count, total_lat, total_lon = count + 1, total_lat + place[0], total_lon + place[1]
            if node.get("id") in wanted:
                points[node.get("id", "")] = place
    if not roads or not count:
        missing = "road, a way with a tag 'highway'" if count else "node with a latitude and a longitude"
        raise GpsecError(f"{map_file}: expected at least one {missing}, found none")
    turns = [_area([points[node] for node in ring if node in points]) for ring in rings]
    left = sum(turn < 0.0 for turn in turns)
    return Extract(roads, (total_lat / count, total_lon / count), left, sum(turn > 0.0 for turn in turns))


def _elements(osm_file: Path, map_file: Path, tag: str) -> Iterator[Element]:
    """Yield the elements of one kind under the root; none of them stays in memory."""
    with osm_file.open("rb") as stream:
        events = ElementTree.iterparse(stream, ("start", "end"))
        _, root = next(events)
        if root.tag != "osm":
            raise GpsecError(f"{map_file}: expected OpenStreetMap data, found <{shown(root.tag)}>")
        for event, element in events:
            if event == "end" and element.tag in {"node", "way", "relation"}:
                if element.tag == tag:
                    yield element
                root.clear()


def _place(node: Element) -> tuple[float, float] | None:
    """Return latitude and longitude of a node, None where it has none."""
    try:
        lat, lon = float(node.get("lat", "nan")), float(node.get("lon", "nan"))
    except ValueError:
        return None
    return (lat, lon) if isfinite(lat) and isfinite(lon) else None


def _area(ring: list[tuple[float, float]]) -> float:
    """Return the area within a ring, or between an arc and its chord, in square degrees; clockwise is negative."""
    if not ring:
        return 0.0
    lat0, lon0 = ring[0]
    flat = [((lon - lon0) * cos(radians(lat0)), lat - lat0) for lat, lon in ring]
    return 0.5 * sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(flat, [*flat[1:], flat[0]], strict=True))
