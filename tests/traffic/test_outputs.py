"""Outputs of a scenario stop no run, wherever they would go: nothing of them is kept."""

import gzip
from pathlib import Path

import pytest

from gpsec.core.errors import GpsecError
from gpsec.traffic.options import resolve_options
from gpsec.traffic.outputs import without_lost_outputs
from gpsec.traffic.session import SumoSession

from .helpers import CAR, ROUTE, TRIP, listing

LOOP = '<e1Detector id="{0}" lane="A0B0_0" pos="9" freq="1" file="{0}"/>'
KEPT = '<poi id="here" type="gpsec.attack" x="3" y="4"><param key="gpsec.radius_m" value="50"/></poi>'


def steps(config: Path) -> int:
    with SumoSession(resolve_options(config, seed=1), {}, lambda departure: True) as session:
        return len(list(session.frames(2.0)))


@pytest.mark.parametrize("file", ["nodir/out.xml", "/nowhere/at/all/out.xml", "../../gone/out.xml", "a/b/c/out.xml.gz"])
def test_a_folder_that_is_not_there_stops_no_run(scenario, tmp_path, file):
    config = scenario(CAR + TRIP, LOOP.format(file) + LOOP.format("here.xml"))
    before = listing(tmp_path)
    assert steps(config) == 20
    assert listing(tmp_path) == before


@pytest.mark.parametrize("file", ["stdout", "stderr", "${OUT}"])
def test_nothing_is_printed(scenario, capfd, monkeypatch, file):
    monkeypatch.setenv("OUT", "stdout")
    assert steps(scenario(CAR + TRIP, LOOP.format(file))) == 20
    assert capfd.readouterr() == ("", "")


def test_devices_of_vehicles_stop_no_run(scenario):
    ssm = '<param key="has.ssm.device" value="true"/><param key="device.ssm.file" value="nodir/ssm.xml"/>'
    assert steps(scenario(f'{CAR}<vehicle id="v" type="car" depart="0">{ssm}{ROUTE}</vehicle>')) == 20


def test_an_included_file_stops_no_run_and_keeps_its_zones(scenario):
    config = scenario(CAR + TRIP, '<include href="a/middle.xml"/><include href="plain.xml"/>')
    (config.parent / "a").mkdir()
    (config.parent / "a" / "middle.xml").write_text('<additional><include href="../inner.xml.gz"/></additional>')
    inner = gzip.compress(f"<additional>{LOOP.format('nodir/ä &amp; b.xml')}{KEPT}</additional>".encode())
    (config.parent / "inner.xml.gz").write_bytes(inner)
    (config.parent / "plain.xml").write_text(
        '<additional><poi id="there" type="gpsec.attack" x="0" y="0"/></additional>'
    )
    with SumoSession(resolve_options(config, seed=1), {}, lambda departure: True) as session:
        assert [zone.zone_id for zone in session.zones({"gpsec.attack": ["gpsec.radius_m"]})] == ["here", "there"]
        assert len(list(session.frames(2.0))) == 20


def test_what_sumo_can_run_is_not_copied(scenario, tmp_path):
    config = scenario(CAR + TRIP, LOOP.format("here.xml") + LOOP.format("NUL"))
    assert without_lost_outputs([config.parent / "more.add.xml"], tmp_path) == {}


def test_a_complaint_about_a_copied_file_names_the_users(scenario):
    config = scenario(CAR + TRIP, LOOP.format("nodir/out.xml") + LOOP.format("x.xml").replace("A0B0_0", "none"))
    with pytest.raises(GpsecError) as caught:
        steps(config)
    assert "gpsec-sumo-" not in str(caught.value)
    assert "none" in str(caught.value)


def test_a_warning_about_a_copied_file_names_the_users(scenario):
    config = scenario(CAR + TRIP, LOOP.format("nodir/out.xml") + '<poly id="old town" shape="0,0 1,0 1,1"/>')
    with SumoSession(resolve_options(config, seed=1), {}, lambda departure: True) as session:
        pass
    assert session.warnings == ["Warning: Invalid characters for Poly ID 'old town'"]


def test_a_complaint_about_an_output_is_in_the_users_words(scenario):
    config = scenario(CAR + TRIP, LOOP.format("here.xml"))
    (config.parent / "sub").mkdir()
    (config.parent / "more.add.xml").write_text(f"<additional>{LOOP.format('sub/' + 'x' * 300)}</additional>")
    with pytest.raises(GpsecError) as caught:
        steps(config)
    assert "../.." not in str(caught.value)
