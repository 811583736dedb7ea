"""Nothing that a scenario says opens a network connection: every way that SUMO has, beside SUMO itself."""

import socket
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from threading import Thread

import pytest
import sumo

from gpsec.core.errors import GpsecError
from gpsec.traffic.network import is_address
from gpsec.traffic.options import resolve_options
from gpsec.traffic.session import SumoSession

from .helpers import CAR, ROUTE, TRIP

SUMO = Path(sumo.SUMO_HOME) / "bin" / "sumo"
FREQUENT = 'freq="1"'
SSM = f'<param key="has.ssm.device" value="true"/><param key="device.ssm.file" value="{{address}}"/>{ROUTE}'
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
ADDITIONAL = "<additional/>"

# What a file says in place of `{address}` and `{url}`: (routes, additional file, options of the configuration).
NAMED = {
    "edge data": (TRIP, f'<edgeData id="e" {FREQUENT} file="{{address}}"/>', ""),
    "lane data": (TRIP, f'<laneData id="e" {FREQUENT} file="{{address}}"/>', ""),
    "induction loop": (TRIP, f'<e1Detector id="e" lane="A0B0_0" pos="5" {FREQUENT} file="{{address}}"/>', ""),
    "instant loop": (TRIP, '<instantInductionLoop id="e" lane="A0B0_0" pos="5" file="{address}"/>', ""),
    "area": (TRIP, f'<e2Detector id="e" lane="A0B0_0" pos="5" length="9" {FREQUENT} file="{{address}}"/>', ""),
    "probe": (TRIP, f'<routeProbe id="e" edge="A0B0" {FREQUENT} file="{{address}}"/>', ""),
    "types": (TRIP, f'<vTypeProbe id="e" {FREQUENT} file="{{address}}"/>', ""),
    "calibrator": (TRIP, f'<calibrator id="e" edge="A0B0" pos="0" {FREQUENT} output="{{address}}"/>', ""),
    "device of a vehicle": (f'{CAR}<vehicle id="v" type="car" depart="0">{SSM}</vehicle>', "", ""),
    "device of an option": (
        CAR + TRIP,
        "",
        '<ssm_device><device.ssm.probability value="1"/><device.ssm.file value="{address}"/></ssm_device>',
    ),
    "outputs": (CAR + TRIP, "", '<output><tripinfo-output value="{address}"/><fcd-output value="{address}"/></output>'),
    "log": (CAR + TRIP, "", '<report><log value="{address}"/></report>'),
}
FETCHED = {
    "schema": ("auto", f'<additional {XSI} xsi:noNamespaceSchemaLocation="{{url}}/a.xsd"/>'),
    "schema of a namespace": ("always", f'<additional {XSI} xsi:schemaLocation="urn:a {{url}}/a.xsd"/>'),
    "document type": ("always", f'<!DOCTYPE additional SYSTEM "{{url}}/a.dtd">{ADDITIONAL}'),
    "entity": ("always", '<!DOCTYPE additional [<!ENTITY e SYSTEM "{url}/e">]><additional>&e;</additional>'),
    "parameter entity": ("auto", f'<!DOCTYPE additional [<!ENTITY % e SYSTEM "{{url}}/e"> %e;]>{ADDITIONAL}'),
}
VALIDATION = ("xml-validation", "xml-validation.net", "xml-validation.routes")
HIDDEN = '<edgeData id="e" freq="1" file="{address}"/>'


class Listener:
    """Counts who connects to a port of this machine."""

    def __init__(self) -> None:
        self._counted = 0
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._socket.getsockname()[1]}"
        Thread(target=self._listen, daemon=True).start()

    @property
    def connections(self) -> int:
        """How many there were; those before ours have been counted once ours is closed."""
        with socket.create_connection(self._socket.getsockname()) as ours:
            ours.recv(1)
        self._counted -= 1
        return self._counted

    def _listen(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return
            self._counted += 1
            connection.close()

    def close(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)  # wakes who waits for the next one
        self._socket.close()


@pytest.fixture
def listener() -> Iterator[Listener]:
    with closing(Listener()) as made:
        yield made


def filled(text: str, listener: Listener) -> str:
    return text.replace("{address}", listener.address).replace("{url}", f"http://{listener.address}")


def run_bare(config: Path) -> None:
    subprocess.run([SUMO, "-c", config, "--end", "3"], capture_output=True, check=False)


def run_here(config: Path) -> str:
    """Run it as gpsec does and return the sentence with which it is refused, empty where it is not."""
    try:
        with SumoSession(resolve_options(config, seed=1), {}, lambda departure: True) as session:
            for _ in session.frames(3.0):
                pass
    except GpsecError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("way", NAMED)
def test_addresses_in_place_of_files_are_not_connected_to(way: str, scenario, listener: Listener) -> None:
    routes, additional, options = (filled(text, listener) for text in NAMED[way])
    config = scenario(routes, additional, options)
    said = run_here(config)
    assert listener.connections == 0
    if not options:
        assert f"expected a file, found the network address '{listener.address}'" in said
    run_bare(config)
    assert listener.connections > 0


@pytest.mark.parametrize("way", FETCHED)
def test_schemas_and_entities_are_not_fetched(way: str, scenario, listener: Listener) -> None:
    value, content = FETCHED[way]
    each = "".join(f'<{name} value="{value}"/>' for name in VALIDATION)
    config = scenario(TRIP, "", f"<report>{each}</report>")
    (config.parent / "more.add.xml").write_text(f'<?xml version="1.0"?>{filled(content, listener)}')
    run_here(config)
    assert listener.connections == 0
    run_bare(config)
    assert listener.connections > 0


@pytest.mark.parametrize(
    ("encoding", "text"),
    [
        ("utf-16", '<?xml version="1.0" encoding="UTF-16"?><additional>{}</additional>'),
        ("cp037", '<?xml version="1.0" encoding="IBM037"?><additional>{}</additional>'),
        ("utf-8", '<?xml version="1.1"?><additional><poi id="a&#1;" x="0" y="0"/>{}</additional>'),
        ("utf-8", '<!DOCTYPE additional [<!ATTLIST edgeData file CDATA "{address}">]><additional>{}</additional>'),
        ("utf-8", "<additional><!-- {} -->{}</additional>"),
    ],
)
def test_no_way_of_writing_hides_an_address(encoding: str, text: str, scenario, listener: Listener) -> None:
    config = scenario(TRIP)
    hidden = HIDDEN if "ATTLIST" not in text else HIDDEN.replace(' file="{address}"', "")
    content = filled(text.replace("{}", hidden), listener)
    (config.parent / "more.add.xml").write_bytes(content.encode(encoding))
    assert "more.add.xml: " in run_here(config)
    assert listener.connections == 0


def test_an_address_in_an_included_file_is_found(scenario, listener: Listener) -> None:
    config = scenario(TRIP, '<include href="inner.xml"/>')
    (config.parent / "inner.xml").write_text(f"<additional>{filled(HIDDEN, listener)}</additional>")
    assert "inner.xml: edgeData: file: expected a file" in run_here(config)
    assert listener.connections == 0


@pytest.mark.parametrize(
    "reading",
    [
        '<include href="{url}/a.xml"/>',
        '<include href="{address}"/>',
        '<rerouter id="r" edges="A0B0" file="{url}/a.xml"/>',
    ],
)
def test_nothing_is_read_from_elsewhere(reading: str, scenario, listener: Listener) -> None:
    run_here(scenario(CAR + TRIP, filled(reading, listener)))
    assert listener.connections == 0


def test_an_address_in_the_environment_is_found(scenario, listener: Listener, monkeypatch) -> None:
    monkeypatch.setenv("ELSEWHERE", listener.address)
    config = scenario(TRIP, HIDDEN.replace("{address}", "${ELSEWHERE}"))
    assert "edgeData: file: expected a file" in run_here(config)
    assert listener.connections == 0


def test_no_port_is_opened_for_others(scenario) -> None:
    options = '<traci_server><remote-port value="8813"/><num-clients value="1"/></traci_server>'
    arguments = resolve_options(scenario(TRIP, "", options), seed=1).arguments
    assert not {"--remote-port", "--num-clients"} & set(arguments)


@pytest.mark.parametrize("name", ["localhost:80", "10.0.0.1:+9", "[::1:80"[1:], "é.example: 80"])
def test_addresses(name: str) -> None:
    assert is_address(name) == (name != "::1:80")


@pytest.mark.parametrize("name", ["out.xml", "C:80", "a/b.xml", "", "NUL", "out:12.xml", "http://x/y", "a:b:80"])
def test_files_are_no_addresses(name: str) -> None:
    assert not is_address(name)
