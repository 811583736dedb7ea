"""`gpsec new`: a scenario folder for a net, which opens in netedit and runs at once."""

import json
import os
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Annotated
from xml.etree import ElementTree

import typer

from gpsec.console.errors import say
from gpsec.core.errors import GpsecError, shown
from gpsec.core.system import in_a_sentence


def new(
    name: Annotated[Path, typer.Argument(metavar="NAME", help="The folder to make; its last part names the scenario.")],
    net: Annotated[Path, typer.Option("--net", metavar="NET", help="Any net of SUMO; the folder refers to it.")],
    duration: Annotated[
        float, typer.Option(min=1.0, max=1e6, metavar="S", help="For how long vehicles depart.")
    ] = 300.0,
    period: Annotated[
        float | None,
        typer.Option(
            min=0.01, max=1e6, metavar="S", help="Mean time between two departures. [default: to suit the net]"
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, metavar="N", help="Of the random demand.")] = 1,
) -> None:
    """Make a scenario folder for a net: random demand, an example attack zone, and a commented gpsec.toml.

    \b
    Examples:
      gpsec new mytown --net town.net.xml
      netedit mytown/mytown.netecfg     (draw zones)
      gpsec run mytown
    """  # noqa: D301
    from gpsec.console.terminal import messages, status

    _check(name, net)
    with (
        in_a_sentence(f"{name}: cannot be made"),
        tempfile.TemporaryDirectory(prefix=f".{name.name}.partial-", dir=name.parent) as work,
    ):
        made = Path(work) / "made"
        with status(messages(), f"{name}: ") as tell:
            said = _fill(made, name, net, period, duration, seed, tell)
        made.chmod(0o755)
        made.rename(name)
    say(f"{name}: {said}, and an example zone")
    say(f"  edit: netedit {name / name.name}.netecfg")
    say(f"  run:  gpsec run {name}")


def _check(folder: Path, net_file: Path) -> None:
    from gpsec.scenario.model import MAX_NAME, NAME
    from gpsec.scenario.paths import UNUSABLE, reason

    try:
        there, beside, net = folder.exists() or folder.is_symlink(), folder.parent.is_dir(), net_file.is_file()
    except UNUSABLE as error:
        raise GpsecError(f"{shown(folder)}: cannot be used as a path: {reason(error)}") from None
    if not NAME.fullmatch(folder.name) or len(folder.name) > MAX_NAME:
        raise GpsecError(
            f"NAME: expected letters, digits, '.', '_' and '-' only, at most {MAX_NAME}, found '{shown(folder.name)}'"
        )
    if there:
        raise GpsecError(f"{folder}: expected a new folder, found one that exists; choose another NAME")
    if not beside:
        raise GpsecError(f"{folder}: cannot be made, there is no folder {folder.parent}")
    if not net:
        raise GpsecError(f"--net {net_file}: expected a net of SUMO, found no such file")


def _fill(
    made: Path,
    folder: Path,
    net_file: Path,
    period_s: float | None,
    duration_s: float,
    seed: int,
    tell: Callable[[str], None],
) -> str:
    from gpsec.demand.make import make_demand
    from gpsec.hdmap.net import read_net
    from gpsec.scenario.paths import TOML_NAME
    from gpsec.scenario.schema import SCHEMA_FILE, json_schema
    from gpsec.scenario.template import busiest_lane, example_zone, netedit_config, sumo_config, toml

    name = folder.name
    demand = make_demand(
        net_file, made, period_s=period_s, duration_s=duration_s, seed=seed, overwrite=False, tell=tell
    )
    demand.sumocfg.unlink()  # ours names the additional file too
    [routes] = made.glob("*.rou.xml")
    [types] = made.glob("*.add.xml")
    routes = routes.rename(made / f"{name}.rou.xml")
    net = Path(os.path.relpath(net_file.resolve(), folder.resolve())).as_posix()
    additional, demands = (types.name, f"{name}.add.xml"), (routes.name,)
    lanes = [lane for lane in read_net(net_file).lanes if not lane.internal]
    edge_of = {lane.lane_id: lane.lane_id.rpartition("_")[0] for lane in lanes}
    zone = example_zone(busiest_lane(lanes, edge_of, _vehicles_on(routes)))
    texts = {
        f"{name}.add.xml": zone,
        f"{name}.netecfg": netedit_config(net, additional, demands),
        f"{name}.sumocfg": sumo_config(net, additional, demands, duration_s),
        TOML_NAME: toml(name, f"{name}.sumocfg", net, duration_s, SCHEMA_FILE),
        SCHEMA_FILE: json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n",
    }
    for file, text in texts.items():
        (made / file).write_text(text, encoding="utf-8")
    return f"{demand.vehicles} vehicles" if demand.vehicles else f"{demand.flows} flows"


def _vehicles_on(routes: Path) -> Counter[str]:
    """Return how many routes of the file lead over each edge."""
    edges: Counter[str] = Counter()
    for _, element in ElementTree.iterparse(routes):
        edges.update(set(element.get("edges", "").split()))
        edges.update({element.get(end, "") for end in ("from", "to")} - {""})
        element.clear()
    return edges
