"""`gpsec check` finds what a run would only meet after a while."""

from pathlib import Path

import pytest

from gpsec import cli
from gpsec.core import shipped

NET = shipped.home() / "sumo_nets" / "slow_curve" / "slow_curve.net.xml"
VEHICLE = '<vehicle id="{id}" type="{type}" depart="{depart}"><route edges="{edges}"/></vehicle>'


def scenario(here: Path, extra: str = "", route_files: str = "town.rou.xml") -> str:
    rows = [
        VEHICLE.format(id="first", type="car", depart=0, edges="-1"),
        VEHICLE.format(id="later", type="car", depart=5000, edges="-1"),
        extra,
    ]
    (here / "town.rou.xml").write_text(f'<routes><vType id="car"/>{"".join(rows)}</routes>')
    (here / "town.sumocfg").write_text(
        f'<configuration><net-file value="{NET}"/><route-files value="{route_files}"/></configuration>'
    )
    return str(here / "town.sumocfg")


@pytest.mark.parametrize(
    ("type_", "edges", "words"),
    [
        ("lorry", "-1", "The vehicle type 'lorry' for vehicle 'last' is not known"),
        ("car", "nowhere", "The edge 'nowhere' within the route for vehicle 'last' is not known"),
    ],
)
def test_what_is_wrong_with_the_last_vehicle(
    type_: str, edges: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["check", scenario(tmp_path)]) == 0
    last = VEHICLE.format(id="last", type=type_, depart=9000, edges=edges)
    assert cli.main(["check", scenario(tmp_path, last)]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("route_files", "words"),
    [
        (str(NET), "expected routes, found a net (<net>)"),
        ("town.sumocfg", "expected routes, found a SUMO configuration (<configuration>)"),
        (".", "which is a folder: expected a file"),
        ("twon.rou.xml", "which does not exist: did you mean 'town.rou.xml'?"),
        ("rush.rou.xml", "which does not exist (of this kind there are: town.rou.xml)"),
        ("rush.flows.xml", "which does not exist\n"),
    ],
)
def test_what_is_no_route_file(
    route_files: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["check", scenario(tmp_path, route_files=route_files)]) == 2
    said = capsys.readouterr().err
    assert f"{tmp_path}/town.sumocfg: route-files names '" in said
    assert words in said
