"""The city that is measured on: a net, steady traffic, and the state of a simulation that is warm already."""

import hashlib
import random
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from gpsec.demand import vehicles
from gpsec.sumo.home import program
from sumo_nets import author, convert, demand
from sumo_nets.networks.grid import Cell, Grid, lay
from sumo_nets.plan import Plan, tmerc

ROOT = Path(__file__).parents[1]
BUILT = ROOT / "benchmarks" / ".built"
SUMO = program("sumo")
BLOCK_M = 270.0
# The streets fill with long steps; the last seconds are simulated as they are measured.
COARSE_STEP_S, STEP_S, SETTLE_S = 0.5, 0.1, 10
LATERAL_RESOLUTION_M = 0.8
LASTS_S = 3600


@dataclass(frozen=True)
class City:
    """A town on a grid, and its traffic.

    Attributes:
        name: of its folder.
        size: junctions a side.
        demand: vehicles per second, such that their number holds.
        warm_s: simulated time until it does.
    """

    name: str
    size: int
    demand: demand.Demand
    warm_s: int

    @property
    def sumocfg(self) -> Path:
        """Configuration that begins with the warm state."""
        return BUILT / self.name / f"{self.name}.sumocfg"


# 190 lane-km, 85 junctions with signals and 116 with priority. Over the first two minutes 2,425 to 2,516 vehicles at
# once, at 6.4 m/s on average, a quarter of them standing; one teleport.
CITY = City("city", 11, demand.Demand(3.1, 2.7, 1200.0, lane_power=0.7), 660)
SMALL_CITY = City("small_city", 4, demand.Demand(0.7, 0.5, 500.0, lane_power=0.7), 200)


def plan(city: City) -> Plan:
    """Return the network: every second street is an arterial road, with signals where it is crossed."""
    chance = random.Random(city.name)
    size = range(city.size)
    last = city.size - 1
    cells = [(column, row) for column in size for row in size]
    column_lanes = {at: 3 if at % 4 == 1 else 2 for at in size if at % 2}
    row_lanes = {at: 2 for at in size if at % 2}
    result = Plan("city", tmerc(52.3, 10.4), curve_resolution_m=0.5)
    lay(
        result,
        Grid(
            columns=[BLOCK_M * at + chance.uniform(-15.0, 15.0) for at in size],
            rows=[BLOCK_M * at + chance.uniform(-15.0, 15.0) for at in size],
            shifts={cell: (chance.uniform(-12.0, 12.0), chance.uniform(-12.0, 12.0)) for cell in cells},
            column_lanes=column_lanes,
            row_lanes=row_lanes,
            bows=_bows(cells, column_lanes, row_lanes, chance),
            stubs={
                **{(0, at): 180.0 for at in size},
                **{(last, at): 0.0 for at in size},
                **{(at, 0): 270.0 for at in size[1:-1]},
                **{(at, last): 90.0 for at in size[1:-1]},
            },
            roundabouts=frozenset(cell for cell in cells if cell[0] % 4 == cell[1] % 4 == 2 and last not in cell),
            bow_radius_m=60.0,
        ),
    )
    return result


def _bows(
    cells: list[Cell], column_lanes: dict[int, int], row_lanes: dict[int, int], chance: random.Random
) -> dict[tuple[Cell, Cell], tuple[float, ...]]:
    """Bend a third of the streets of one and two lanes, to one side or to both in turn."""
    bows: dict[tuple[Cell, Cell], tuple[float, ...]] = {}
    for column, row in cells:
        east, north = (column + 1, row), (column, row + 1)
        for end, lanes in ((east, row_lanes.get(row, 1)), (north, column_lanes.get(column, 1))):
            bow = chance.choice((-1.0, 1.0)) * chance.uniform(14.0, 22.0)
            if lanes < 3 and chance.random() < 0.35:
                bows[(column, row), end] = (bow,) if chance.random() < 0.5 else (bow, -bow)
    return bows


def build(city: City) -> None:
    """Make the folder of a city, unless it holds already what would be made."""
    target = city.sumocfg.parent
    stamp = _stamp(city)
    if (target / "stamp").is_file() and (target / "stamp").read_text() == stamp:
        return
    BUILT.mkdir(exist_ok=True)
    folder = Path(tempfile.mkdtemp(dir=BUILT))
    try:
        _write(city, folder)
        _warm_up(city, folder)
        (folder / "stamp").write_text(stamp)
        shutil.rmtree(target, ignore_errors=True)
        folder.rename(target)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _stamp(city: City) -> str:
    """Return what changes with everything that a city depends on."""
    digest = hashlib.sha256(f"{city} {version('eclipse-sumo')}".encode())
    makers = [ROOT / "gpsec" / folder for folder in ("demand", "opendrive")]
    for path in (
        Path(__file__),
        *(path for folder in (ROOT / "sumo_nets", *makers) for path in sorted(folder.rglob("*.py"))),
    ):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _write(city: City, folder: Path) -> None:
    source, net = folder / "city.xodr", folder / "city.net.xml"
    made = plan(city)
    author.write(made, source)
    convert.netconvert(made, source, net)
    flows = demand.routes(city.name, city.demand, net, city.warm_s + LASTS_S)
    (folder / "city.rou.xml").write_text(flows, encoding="utf-8")
    (folder / "types.add.xml").write_text(vehicles.document(), encoding="utf-8")
    for name, state, begin_s, step_s in (
        ("empty", "", 0, COARSE_STEP_S),
        ("coarse", "coarse.xml.gz", city.warm_s - SETTLE_S, STEP_S),
        (city.name, "warm.xml.gz", city.warm_s, STEP_S),
    ):
        text = _sumocfg(state, begin_s, city.warm_s + LASTS_S, step_s, city.demand.teleport_s)
        (folder / f"{name}.sumocfg").write_text(text, encoding="utf-8")


def _warm_up(city: City, folder: Path) -> None:
    for name, state, at_s in (("empty", "coarse", city.warm_s - SETTLE_S), ("coarse", "warm", city.warm_s)):
        options = (
            f"--end {at_s + 1} --save-state.times {at_s} --save-state.files {state}.xml.gz --save-state.precision 6"
        )
        command = [str(SUMO), "-c", f"{name}.sumocfg", "--no-step-log", "--seed", "1", *options.split()]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)


def _sumocfg(state: str, begin_s: int, end_s: int, step_s: float, teleport_s: int) -> str:
    load = f'\n        <load-state value="{state}"/>' if state else ""
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<sumoConfiguration>
    <input>
        <net-file value="city.net.xml"/>
        <route-files value="city.rou.xml"/>
        <additional-files value="types.add.xml"/>{load}
    </input>
    <time>
        <begin value="{begin_s}"/>
        <end value="{end_s}"/>
        <step-length value="{step_s}"/>
    </time>
    <routing>
        <weights.random-factor value="2"/>
    </routing>
    <processing>
        <lateral-resolution value="{LATERAL_RESOLUTION_M}"/>
        <time-to-teleport value="{teleport_s}"/>
        <collision.action value="warn"/>
    </processing>
</sumoConfiguration>
"""
