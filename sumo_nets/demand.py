"""Makes the traffic scenarios from the networks: `python -m sumo_nets.demand [NAME ...]`."""

from __future__ import annotations

import argparse
import random
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sumolib

from gpsec.demand import vehicles

NETS = Path(__file__).parent
SCENARIOS = NETS.parent / "scenarios"
END_S = 360


@dataclass(frozen=True)
class Demand:
    """How much traffic a scenario gets, and from where.

    `outer` vehicles per second enter at the edges of the network, `inner` ones begin on streets inside it.
    Only trips of at least `shortest_m` are made.
    """

    outer_per_s: float
    inner_per_s: float
    shortest_m: float
    zones: tuple[str, ...] = ()
    lane_power: float = 1.0
    """An entry's and an exit's weight is its number of lanes to this power."""
    targets: int = 4
    """Destinations per street inside the network."""
    teleport_s: int = 180


POLYGON_PARAMS = {
    "gpsec.attack": "constant_bias",
    "gpsec.begin": "60",
    "gpsec.end": "300",
    "gpsec.share": "0.5",
    "gpsec.bias_m": "2.4",
}


def polygon(name: str, shape: Iterable[tuple[float, float]]) -> str:
    """Return an attack zone that is drawn as a polygon."""
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in shape)
    head = f'    <poly id="{name}" type="gpsec.attack" color="255,60,60,80" fill="1" layer="-1.00" shape="{corners}">'
    return "\n".join([head, *_params(POLYGON_PARAMS), "    </poly>"])


def point(name: str, x: float, y: float, radius_m: int) -> str:
    """Return an attack zone that is drawn as a point with a radius."""
    head = f'    <poi id="{name}" type="gpsec.attack" color="255,60,60" layer="10.00" x="{x:.1f}" y="{y:.1f}">'
    return "\n".join([head, *_params(POLYGON_PARAMS | {"gpsec.radius_m": str(radius_m)}), "    </poi>"])


def _params(params: dict[str, str]) -> list[str]:
    """Parameter elements of a zone."""
    return [f'        <param key="{key}" value="{value}"/>' for key, value in params.items()]


DEMANDS = {
    "slow_curve": Demand(0.48, 0.28, 1800.0),
    "sharp_turns": Demand(0.45, 0.38, 1000.0),
    "town": Demand(
        2.0,
        0.9,
        900.0,
        (
            polygon("spoofed_quarter", [(500.0, 180.0), (980.0, 180.0), (980.0, 640.0), (500.0, 640.0)]),
            point("spoofer", 1224.0, 872.0, 150),
        ),
    ),
    "highway": Demand(
        1.9,
        0.8,
        2500.0,
        (
            polygon(
                "spoofed_bend",
                [
                    (2600.0, 620.0),
                    (3500.0, 1120.0),
                    (4100.0, 1050.0),
                    (4100.0, 850.0),
                    (3400.0, 800.0),
                    (2700.0, 400.0),
                ],
            ),
            point("spoofer", 7000.0, 1750.0, 150),
        ),
    ),
    "mountain": Demand(0.4, 0.4, 1500.0),
    "suburb": Demand(0.95, 0.3, 600.0),
    "beltway": Demand(1.0, 0.2, 1200.0),
}


def routes(name: str, demand: Demand, net_file: Path | None = None, end_s: int = END_S) -> str:
    """Return the route file: flows from every entry to every exit, and from streets inside to some exits.

    The net is that of this name in `NETS`, where no other `net_file` is given.
    """
    net = sumolib.net.readNet(str(net_file or NETS / name / f"{name}.net.xml"))
    edges = sorted(net.getEdges(False), key=lambda edge: str(edge.getID()))
    entries = [edge for edge in edges if not edge.getIncoming()]
    exits = [edge for edge in edges if not edge.getOutgoing()]
    inner = [edge for edge in edges if edge.getIncoming() and edge.getOutgoing() and edge.getLength() > 90.0]
    inner = [edge for edge in inner if edge.getSpeed() > 9.0]
    chance = random.Random(name)
    rows = _flows(net, entries, exits, demand.outer_per_s, demand, None, chance)
    rows += _flows(net, inner, exits, demand.inner_per_s, demand, demand.targets, chance)
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<routes>"]
    for origin, target, rate in rows:
        lines.append(
            f'    <flow id="{_label(origin)}_{_label(target)}" type="traffic" from="{origin}" to="{target}" begin="0" '
            f'end="{end_s}" period="exp({rate:.5f})" departLane="best" departSpeed="max" departPos="base"/>'
        )
    return "\n".join([*lines, "</routes>", ""])


def _flows(
    net: Any,
    origins: list[Any],
    exits: list[Any],
    per_s: float,
    demand: Demand,
    targets: int | None,
    chance: random.Random,
) -> list[tuple[str, str, float]]:
    """Origin, destination and rate of each flow, rates in proportion to lanes."""
    weighted: list[tuple[str, str, float]] = []
    for origin in origins:
        choice = []
        for target in exits:
            if target.getToNode() == origin.getFromNode():
                continue
            path, _ = net.getShortestPath(origin, target)
            if path is None or sum(edge.getLength() for edge in path) < demand.shortest_m:
                continue
            choice.append(target)
        if targets is not None and len(choice) > targets:
            choice = sorted(chance.sample(choice, targets), key=lambda edge: str(edge.getID()))
        total = sum(_weight(target, demand) for target in choice)
        for target in choice:
            share = _weight(target, demand) / total
            weighted.append((str(origin.getID()), str(target.getID()), _weight(origin, demand) * share))
    scale = per_s / sum(weight for _, _, weight in weighted)
    return [(origin, target, weight * scale) for origin, target, weight in weighted]


def _weight(edge: Any, demand: Demand) -> float:
    """How much traffic a road gets: by its lanes, less for the side roads of a trunk."""
    side = 0.2 if str(edge.getName()).startswith("side road") else 1.0
    return float(side * edge.getLaneNumber() ** demand.lane_power)


def _label(edge: str) -> str:
    """Return an edge id as a part of a vehicle's name."""
    return edge.replace("-", "r").replace("#", "s")


def write(name: str, demand: Demand) -> None:
    """Write a scenario's folder."""
    folder = SCENARIOS / name
    folder.mkdir(parents=True, exist_ok=True)
    zones = '<?xml version="1.0" encoding="UTF-8"?>\n<additional>\n' + "".join(f"{zone}\n" for zone in demand.zones)
    (folder / f"{name}.rou.xml").write_text(routes(name, demand), encoding="utf-8")
    (folder / f"{name}.add.xml").write_text(zones + "</additional>\n", encoding="utf-8")
    (folder / f"{name}.sumocfg").write_text(_sumocfg(name, demand), encoding="utf-8")
    (folder / f"{name}.netecfg").write_text(_netecfg(name), encoding="utf-8")


def _sumocfg(name: str, demand: Demand) -> str:
    """Return the configuration that sumo and sumo-gui open."""
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<sumoConfiguration>
    <input>
        <net-file value="../../sumo_nets/{name}/{name}.net.xml"/>
        <route-files value="{name}.rou.xml"/>
        <additional-files value="../vehicle_types.add.xml,{name}.add.xml"/>
    </input>
    <time>
        <begin value="0"/>
        <end value="{END_S}"/>
        <step-length value="0.1"/>
    </time>
    <processing>
        <lateral-resolution value="0.8"/>
        <time-to-teleport value="{demand.teleport_s}"/>
        <collision.action value="warn"/>
    </processing>
    <report>
        <no-step-log value="true"/>
        <duration-log.disable value="true"/>
    </report>
    <random_number>
        <seed value="42"/>
    </random_number>
</sumoConfiguration>
"""


def _netecfg(name: str) -> str:
    """Return the configuration that netedit opens."""
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<neteditConfiguration>
    <input>
        <sumo-net-file value="../../sumo_nets/{name}/{name}.net.xml"/>
        <additional-files value="../vehicle_types.add.xml,{name}.add.xml"/>
        <route-files value="{name}.rou.xml"/>
    </input>
</neteditConfiguration>
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m sumo_nets.demand", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one or more of {', '.join(DEMANDS)} (default: all)")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.names if name not in DEMANDS]
    if unknown:
        print(f"There is no scenario {unknown[0]!r}; there are {', '.join(DEMANDS)}.", file=sys.stderr)
        return 2
    SCENARIOS.mkdir(exist_ok=True)
    (SCENARIOS / "vehicle_types.add.xml").write_text(vehicles.document(), encoding="utf-8")
    for name in options.names or DEMANDS:
        write(name, DEMANDS[name])
    return 0


if __name__ == "__main__":
    sys.exit(main())
