"""A small scenario that is in order, for each test to break one thing of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

Files = Mapping[str, str | bytes | None]

CAR = '<vType id="car" vClass="passenger"/>'
FLOW = '<flow id="f" type="car" begin="0" end="20" period="3" from="A0A1" to="B2C2"/>'
INPUTS = (
    '<input><net-file value="grid.net.xml"/><route-files value="cars.rou.xml"/>'
    '<additional-files value="more.add.xml"/></input>'
)


def config(options: str = "", inputs: str = INPUTS) -> str:
    return f"<configuration>{inputs}{options}</configuration>"


def routes(content: str) -> str:
    return f"<routes>{content}</routes>"


def car(parameter: str, value: str) -> str:
    """Routes whose vehicle type has a parameter."""
    return routes(f'<vType id="car"><param key="{parameter}" value="{value}"/></vType>{FLOW}')


def zone(parameters: Mapping[str, str], shape: str = "0,0 100,0 100,100", kind: str = "gpsec.attack") -> str:
    """An additional file with a polygon that has parameters."""
    return _drawn(f'poly id="z" type="{kind}" shape="{shape}"', "poly", parameters)


def point(parameters: Mapping[str, str], x: str = "0") -> str:
    """An additional file with a point that has parameters."""
    return _drawn(f'poi id="z" type="gpsec.attack" x="{x}" y="0"', "poi", parameters)


def _drawn(start: str, tag: str, parameters: Mapping[str, str]) -> str:
    inner = "".join(f'<param key="gpsec.{key}" value="{value}"/>' for key, value in parameters.items())
    return f"<additional><{start}>{inner}</{tag}></additional>"


@dataclass(frozen=True)
class Case:
    """One thing that is wrong.

    Attributes:
        says: fragments of the one line on standard error.
        files: what the scenario `s` holds in place of what is in order; None leaves a file out.
        arguments: of the command line.
        prepare: what is done in the folder that the command is run in.
        net: changes the text of the net.
    """

    says: tuple[str, ...]
    files: Files = field(default_factory=dict)
    arguments: tuple[str, ...] = ("check", "s")
    prepare: Callable[[Path], None] | None = None
    net: Callable[[str], str | bytes] | None = None


def lay_out(here: Path, net: str, case: Case) -> None:
    """Write the scenario `s` of a case into the folder `here`."""
    files: dict[str, str | bytes | None] = {
        "grid.net.xml": case.net(net) if case.net else net,
        "cars.rou.xml": routes(CAR + FLOW),
        "more.add.xml": "<additional/>",
        "run.sumocfg": config(),
        **case.files,
    }
    (here / "s").mkdir()
    for name, content in files.items():
        if content is not None:
            (here / "s" / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    if case.prepare:
        case.prepare(here)
