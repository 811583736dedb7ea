"""What netedit saves still runs, and attacks the same: the scenario is opened, saved, and compared."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import pytest

from gpsec import cli
from gpsec.scenario.template import netedit_config, sumo_config
from gpsec.traffic import remote
from gpsec.traffic.inputs import own_parameters
from gpsec.traffic.session import SumoSession

DOCS = Path(__file__).parents[2] / "docs"
ZONES = """<additional>
    <vType id="car" vClass="passenger" sigma="0.3"/>
    <vType id="van" vClass="delivery">
        <param key="gpsec.attack" value="stealth"/>
        <param key="gpsec.radius_m" value="42.5"/>
    </vType>
    <poly id="yard" type="gpsec.attack" color="red" fill="1" layer="10" shape="0,-20 90,-20 90,20.25 0,20 0,-20">
        <param key="gpsec.attack" value="constant_bias"/>
        <param key="gpsec.share" value="0.5"/>
    </poly>
    <poi id="mast" type="gpsec.attack" color="red" layer="10" x="150.5" y="7">
        <param key="gpsec.attack" value="jamming"/>
        <param key="gpsec.radius_m" value="60"/>
    </poi>
</additional>"""
ROUTES = """<routes>
    <flow id="own" type="car" from="a" to="b" begin="0" end="30" number="3">
        <param key="gpsec.attack" value="drift"/>
        <param key="gpsec.rate_mps" value="0.25"/>
    </flow>
    <trip id="s" type="van" from="a" to="b" depart="2"/>
    <vehicle id="one" type="car" depart="5">
        <route edges="a b"/>
        <param key="gpsec.attack" value="noise"/>
    </vehicle>
</routes>"""


@pytest.fixture(scope="module")
def driver() -> ModuleType:
    """The script in docs, which is no package."""
    spec = importlib.util.spec_from_file_location("docs_netedit", DOCS / "netedit.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    if programs := module.missing():
        pytest.skip(f"not on this machine: {', '.join(programs)}")
    return module


def said(folder: Path) -> set[tuple[str, ...]]:
    """Every parameter of ours, with who has it."""
    found = [own for name in ("road.add.xml", "road.rou.xml") for own in own_parameters(folder / name)]
    return {(own.element, own.owner_id, own.owner_type, own.key, own.value) for own in found}


def shapes(folder: Path) -> dict[str, list[float]]:
    root = ElementTree.parse(folder / "road.add.xml").getroot()
    corners = [[float(x) for x in poly.get("shape", "").replace(",", " ").split()] for poly in root.iter("poly")]
    points = [[float(poi.get("x", "")), float(poi.get("y", ""))] for poi in root.iter("poi")]
    return {"poly": [x for each in corners for x in each], "poi": [x for each in points for x in each]}


def test_what_netedit_saves_is_what_it_opened(
    driver: ModuleType,
    tmp_path: Path,
    plain_net: object,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    folder = tmp_path / "road"
    folder.mkdir()
    nodes = 'id="n0" x="0" y="0"\nid="n1" x="200" y="0"\nid="n2" x="400" y="50"'
    edges = 'id="a" from="n0" to="n1" numLanes="2"\nid="b" from="n1" to="n2" numLanes="2"'
    (folder / "road.net.xml").write_bytes(plain_net(nodes, edges).read_bytes())  # type: ignore[operator]
    (folder / "road.add.xml").write_text(ZONES)
    (folder / "road.rou.xml").write_text(ROUTES)
    files = ("road.net.xml", ["road.add.xml"], ["road.rou.xml"])
    (folder / "road.netecfg").write_text(netedit_config(*files))
    (folder / "road.sumocfg").write_text(sumo_config(*files, 60.0))
    before, drawn = said(folder), shapes(folder)
    assert len(before) == 9
    with driver.Netedit(folder / "road.netecfg", 45.0, 0.0, 150.0) as netedit:
        netedit.save_all()
    for name in ("road.add.xml", "road.rou.xml"):
        assert "by Eclipse SUMO netedit" in (folder / name).read_text(), name
    assert said(folder) == before
    for kind, numbers in shapes(folder).items():
        assert numbers == pytest.approx(drawn[kind], abs=0.01), kind
    monkeypatch.setattr(remote, "RemoteSession", SumoSession)  # in this process, which is faster
    assert cli.main(["check", str(folder), "--set", "plans=[]"]) == 0
    # None, two zones, the van, the flow and the vehicle.
    assert "6 plans with none" in capsys.readouterr().out
