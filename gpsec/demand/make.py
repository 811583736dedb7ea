"""Makes a plausible random demand for any net, as a folder that `gpsec run` takes."""

import bz2
import gzip
import os
import tempfile
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from gpsec.core.errors import GpsecError
from gpsec.core.system import refusal
from gpsec.demand.trips import length_m, random_trips, straight_flows
from gpsec.demand.vehicles import document
from gpsec.hdmap.net import Lane, read_net

TYPES_FILE = "vehicle_types.add.xml"
_MAPS = {"osm": "an OpenStreetMap extract", "OpenDRIVE": "an OpenDRIVE map"}
_PACKED: dict[bytes, Callable[..., Any]] = {b"\x1f\x8b": gzip.open, b"BZh": bz2.open}
_NO_XML = (OSError, EOFError, zlib.error, ElementTree.ParseError, LookupError, ValueError, StopIteration)
# Departures an hour on a kilometre of lane, and the bounds of what comes of it.
_PER_LANE_KM_AND_HOUR = 120.0
_SHORTEST_PERIOD_S, _LONGEST_PERIOD_S = 0.4, 4.0


@dataclass(frozen=True)
class Demand:
    """What was made.

    Attributes:
        sumocfg: the configuration, for `gpsec run`.
        vehicles: number of vehicles with a random trip; 0 where there are flows.
        flows: number of flows, 0 where there are trips.
        period_s: mean time between two departures.
    """

    sumocfg: Path
    vehicles: int
    flows: int
    period_s: float


def demand_files(net_file: Path, out: Path, overwrite: bool) -> dict[str, Path]:
    """Return the files that a demand consists of, by kind: ``routes``, ``types``, ``sumocfg``.

    Raises:
        GpsecError: they cannot be written there, or exist and may not be replaced.
    """
    name = net_name(net_file)
    files = {"routes": out / f"{name}.rou.xml", "types": out / TYPES_FILE, "sumocfg": out / f"{name}.sumocfg"}
    if out.exists() and not out.is_dir():
        raise GpsecError(f"{out}: expected a folder to write to, found a file")
    if not out.parent.is_dir():
        raise GpsecError(f"{out}: cannot be made, there is no folder {out.parent}")
    for path in files.values():
        if path.is_dir():
            raise GpsecError(f"{path}: cannot be written, it is a folder")
        if path.exists() and not overwrite:
            raise GpsecError(f"{path}: exists; give --overwrite to replace it, or choose another --out")
    return files


def refuse_map(net_file: Path) -> None:
    """Refuse a map that has to be imported first.

    Raises:
        GpsecError: the file is an OpenStreetMap extract or an OpenDRIVE map.
    """
    found = _MAPS["osm"] if net_file.suffix == ".pbf" else _MAPS.get(_root_tag(net_file))
    if found:
        raise GpsecError(f"{net_file}: expected a net of SUMO, found {found}; make one with gpsec import {net_file}")


def _root_tag(file: Path) -> str:
    """Return the name of a file's outermost XML element, "" where it is no XML."""
    with suppress(*_NO_XML):
        with file.open("rb") as raw:
            magic = raw.read(3)
        unpack: Callable[..., Any] = next((opened for mark, opened in _PACKED.items() if magic.startswith(mark)), open)
        with unpack(file, "rb") as stream:
            _, root = next(ElementTree.iterparse(stream, ("start",)))
            return str(root.tag)
    return ""


def net_name(net_file: Path) -> str:
    """Return a net's name without what SUMO's nets end in."""
    return net_file.name.removesuffix(".gz").removesuffix(".xml").removesuffix(".net")


def make_demand(
    net_file: Path,
    out: Path,
    *,
    period_s: float | None,
    duration_s: float,
    seed: int,
    overwrite: bool,
    tell: Callable[[str], None],
) -> Demand:
    """Write vehicle types, routes and a configuration for a net into the folder `out`.

    Trips are random, from and to the edges of the net more often than inside it. Where no trip is possible, as on a
    map of a single road, vehicles drive along each road.

    Args:
        net_file: any net of SUMO.
        out: folder, made where there is none.
        period_s: mean time between two departures, None for one that suits the size of the net.
        duration_s: for how long vehicles depart.
        seed: of all that is random.
        overwrite: replace what is there.
        tell: is told what is being done.

    Raises:
        GpsecError: the net or a file cannot be used. Nothing is left behind then.
    """
    refuse_map(net_file)
    files = demand_files(net_file, out, overwrite)
    tell("reading the net")
    lanes = [lane for lane in read_net(net_file).lanes if not lane.internal]
    period = suitable_period_s(lanes) if period_s is None else period_s
    try:
        with tempfile.TemporaryDirectory(prefix=".gpsec-demand-", dir=out.parent) as name:
            work = Path(name).resolve()  # tools run inside it
            types = work / TYPES_FILE
            types.write_text(document(), encoding="utf-8")
            tell("random trips")
            text, vehicles = random_trips(net_file.resolve(), types, work, period, duration_s, seed)
            flows = 0
            if not vehicles:
                text, flows = straight_flows(lanes, period, duration_s)
            if not vehicles and not flows:
                raise GpsecError(f"{net_file}: expected a road on which a vehicle can drive some way, found none")
            (work / "routes").write_text(text, encoding="utf-8")
            (work / "sumocfg").write_text(_sumocfg(net_file, files, duration_s, seed), encoding="utf-8")
            out.mkdir(exist_ok=True)
            for made, kind in ((types, "types"), (work / "routes", "routes"), (work / "sumocfg", "sumocfg")):
                made.replace(files[kind])
    except OSError as error:
        raise refusal(error, f"{out}: cannot be written") from None
    return Demand(files["sumocfg"], vehicles, flows, period)


def suitable_period_s(lanes: list[Lane]) -> float:
    """Return a mean time between departures that gives a net light traffic, with something to see on a small one."""
    kilometres = sum(length_m(lane) for lane in lanes) / 1000.0
    return min(max(3600.0 / (_PER_LANE_KM_AND_HOUR * max(kilometres, 1e-3)), _SHORTEST_PERIOD_S), _LONGEST_PERIOD_S)


def _sumocfg(net_file: Path, files: dict[str, Path], duration_s: float, seed: int) -> str:
    """Return the configuration; paths are relative, so that folder and net can be moved together."""
    net = Path(os.path.relpath(net_file.resolve(), files["sumocfg"].parent.resolve())).as_posix()
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<sumoConfiguration>
    <input>
        <net-file value="{_escaped(net)}"/>
        <route-files value="{_escaped(files["routes"].name)}"/>
        <additional-files value="{TYPES_FILE}"/>
    </input>
    <time>
        <begin value="0"/>
        <end value="{duration_s:g}"/>
        <step-length value="0.1"/>
    </time>
    <processing>
        <lateral-resolution value="0.8"/>
        <time-to-teleport value="180"/>
        <collision.action value="warn"/>
    </processing>
    <random_number>
        <seed value="{seed}"/>
    </random_number>
</sumoConfiguration>
"""


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
