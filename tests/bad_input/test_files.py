"""Each of these is one sentence that names file and key, exit status 2, and nothing on the disk."""

import gzip
import os
import re
import shutil
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.traffic import remote
from gpsec.traffic.session import SumoSession

from .worlds import CAR, FLOW, INPUTS, Case, car, config, lay_out, point, routes, zone


def toml(text: str | bytes, *says: str) -> Case:
    return Case(("s/gpsec.toml", *says), {"gpsec.toml": text})


def set_(text: str, *says: str) -> Case:
    return Case((f"--set {text.splitlines()[0]}", *says), arguments=("check", "s", "--set", text))


def plan(keys: str, *says: str) -> Case:
    return toml(f'[[plans]]\nattack = "drift"\n{keys}', "plans.0", *says)


def options(text: str, *says: str) -> Case:
    return Case(("run.sumocfg", *says), {"run.sumocfg": config(text)})


def drawn(additional: str, *says: str) -> Case:
    return Case(("more.add.xml", *says), {"more.add.xml": additional})


def netted(pattern: str, with_: str, *says: str) -> Case:
    return Case(("grid.net.xml", *says), net=lambda net: re.sub(pattern, with_, net, flags=re.S))


def damaged(content: bytes) -> bytes:
    """Gzip whose beginning can be read and whose middle cannot."""
    packed = bytearray(gzip.compress(content))
    packed[30:50] = b"\x99" * 20
    return bytes(packed)


def loop(here: Path) -> None:
    (here / "s" / "loop").symlink_to("loop")


def folder_for_sumocfg(here: Path) -> None:
    (here / "s" / "run.sumocfg").unlink()
    (here / "s" / "run.sumocfg").mkdir()


def carried(inside: str, *says: str) -> Case:
    content = routes(f'{CAR}{FLOW}<vType id="van">{inside}</vType>')
    return Case(("cars.rou.xml: vType 'van'", *says), {"cars.rou.xml": content})


DRIFT = {"attack": "drift"}
MULTIPATH = "gpsec.multipath"
SPOOFS = '<param key="gpsec.attack" value="drift"/>'
ONE_PLAN = '<param key="gpsec.plan" value="one"/>'
LANE = r'(<lane id="A0A1_0" [^>]*)'
LONG = "x" * 5000
# C1 controls and bidi marks may stand in XML; any character may stand in TOML.
STEERS = "\x9b2J\u202e"
ESCAPED = "\\x9b2J\\u202e"

# What is found before SUMO is started.
EARLY = {
    # what floods or steers the terminal
    "net whose name is too long": Case(
        ("run.sumocfg: net-file names '", "x.net.xml', which does not exist"),
        {"run.sumocfg": config(inputs=INPUTS.replace("grid", LONG))},
    ),
    "run to report on whose name is too long": Case(
        ("xxx", "cannot be used: File name too long"), arguments=("report", LONG)
    ),
    "run to trace whose name is too long": Case(
        ("xxx", "cannot be used: File name too long"), arguments=("trace", LONG, "a")
    ),
    "map whose name is too long": Case(("xxx", "cannot be used: File name too long"), arguments=("import", LONG)),
    "net in a folder whose name is too long": Case(
        ("run.sumocfg: net-file names '", "/grid.net.xml', which does not exist"),
        {"run.sumocfg": config(inputs=INPUTS.replace("grid", f"{LONG}/grid"))},
    ),
    "routes of which one has a name that is too long": Case(
        ("run.sumocfg: route-files names '",), {"run.sumocfg": config(inputs=INPUTS.replace("cars", f"{LONG} a"))}
    ),
    "long option": options(f"<{LONG} value='1'/>", "not known to SUMO"),
    "long value of an option": options(f"<step-length value='{LONG}'/>", "expected seconds or h:m:s, found 'xx"),
    "option that steers": options(f"<step-length value='{STEERS}'/>", f"found '{ESCAPED}'"),
    "long value": toml(f"fleet.profile = '{LONG}'", "fleet.profile", "unknown profile 'xx"),
    "long key": toml(f"{LONG} = 1", "unknown key 'xx"),
    "value that steers": toml('fleet.profile = "\\u001b[2J\\u202e"', "unknown profile '\\x1b[2J\\u202e'"),
    "list that is long": toml(f"fleet.profile = [{'1, ' * 5000}]", "fleet.profile"),
    "path that is too long": toml(f"sumocfg = '{LONG}'", "sumocfg: expected a path, found 'xx", "too long"),
    "parameter that steers": Case(
        ("cars.rou.xml: vType 'car': unknown parameter 'gpsec." + ESCAPED,),
        {"cars.rou.xml": car(f"gpsec.{STEERS}", "1")},
    ),
    # gpsec.toml
    "huge whole number": toml(f"duration_s = 1{'0' * 400}", "duration_s: expected a number"),
    "number of too many digits": toml(f"seed = 1{'0' * 5000}", "not valid TOML"),
    "too deep": toml(f"seed = {'[' * 5000}", "not valid TOML"),
    "unknown key of the world": toml("[world]\ncamra_factor = 2.0", "in world: did you mean 'camera_factor'?"),
    "negative noise": toml("[world]\ngnss_slow_factor = -1.0", "world.gnss_slow_factor: expected at least 0"),
    "map that is nowhere": toml("[world]\nmap_road_m = 3.0", "world.map_road_m: expected at most 2, found 3"),
    "endless duration": toml("duration_s = 1e308", "duration_s: expected at most 1e+07"),
    "binary": toml(bytes(range(256)), "expected TOML in UTF-8"),
    "too fine a step": toml("traffic.step_s = 1e-9", "traffic.step_s: expected at least 0.001"),
    "too fine sublanes": toml("traffic.lateral_resolution_m = 1e-4", "traffic.lateral_resolution_m", "0.1 to 5"),
    "negative begin of SUMO": toml("traffic.begin_s = -1", "traffic.begin_s: expected at least 0, found -1"),
    "text for the begin of SUMO": toml("traffic.begin_s = '8h'", "traffic.begin_s: expected a number, found '8h'"),
    "begin of SUMO after its end": Case(
        ("traffic.begin_s: expected less than the end in", "run.sumocfg", "20 s, found 30 s"),
        {"run.sumocfg": config('<end value="20"/>'), "gpsec.toml": "traffic.begin_s = 30.0"},
    ),
    "section that is a number": toml("fleet = 3", "fleet: expected a table, found 3"),
    "plans that are a table": toml("[plans]\nattack = 'drift'", "plans: expected a list"),
    "plan that is a text": toml("plans = ['drift']", "plans.0: expected a table, found 'drift'"),
    "defence without a response": toml("[[defences]]\ndetector = 'lstm_glr'", "defences.0.response: is missing"),
    "share over one": plan("share = 1.5", "share", "1.5"),
    "vehicles that are a text": plan("vehicles = 'a'", "vehicles: expected", "found 'a'"),
    "vehicle that is a number": plan("vehicles = [3]", "vehicles", "found 3"),
    "window beside a zone": plan("zone = 'z'\nduration_s = [1, 2]", "duration_s: expected none beside a zone"),
    "key given twice": toml("seed = 1\nseed = 2", "not valid TOML"),
    "long name": toml(f"name = '{'x' * 300}'", "name: expected at most 100 characters, found 300"),
    "empty profile": toml("fleet.profile = {}", "fleet.profile: expected shares that add up to 1"),
    "share of a profile that is not a number": toml("fleet.profile = {carla = nan}", "fleet.profile.carla", "finite"),
    "user without a home": toml("sumocfg = '~nobody-there/x.sumocfg'", "sumocfg: expected a path"),
    "path with a zero byte": toml('sumocfg = "a\\u0000b"', "sumocfg: expected a path", "null byte"),
    "endless path": toml(f"sumocfg = '{'x' * 5000}'", "sumocfg: expected a path", "file name too long"),
    "path in a circle": Case(
        ("s/gpsec.toml: sumocfg: expected a path", "loop"), {"gpsec.toml": "sumocfg = 'loop'"}, prepare=loop
    ),
    "folder as sumocfg": toml("sumocfg = '.'", "sumocfg: expected a .sumocfg, found no file"),
    # plans
    "endless window": plan("duration_s = [1, 1e300]", "duration_s: expected", "1e+07", "found 1e+300"),
    "huge window": plan(f"duration_s = [1, 1{'0' * 400}]", "duration_s: expected"),
    "endless begin": plan("begin_s = 1e300", "begin_s", "1e+300"),
    "negative begin": plan("begin_s = -5", "begin_s", "-5"),
    "parameter that is not a number": plan("rate_mps = nan", "rate_mps: expected a finite number, found nan"),
    "unknown vehicle type": Case(
        ("plans.0.vehicle_types: unknown vehicle type 'cra': did you mean 'car'?",),
        {"gpsec.toml": '[[plans]]\nattack = "drift"\nvehicle_types = ["cra"]'},
    ),
    # --set
    "--set of two lines": set_("seed=1\nengine='x'", "expected one value"),
    "--set of a negative position": set_("plans.-1.share=1", "plans has nothing called '-1'"),
    "--set of an infinite seed": set_("seed=1e400", "seed: expected a whole number, found inf"),
    "--set of an unknown parameter": set_("plans.drift.rate=1", "unknown key 'rate'", "did you mean 'rate_mps'?"),
    # the command line
    "endless argument": Case(("xxx: cannot be used as a path: file name too long",), arguments=("check", "x" * 5000)),
    "sumocfg is a folder": Case(("s: expected one .sumocfg, found none",), prepare=folder_for_sumocfg),
    # the configuration of SUMO
    "configuration is a net": Case(
        ("s/grid.net.xml: expected a SUMO configuration, found a net",), {"gpsec.toml": "sumocfg = 'grid.net.xml'"}
    ),
    "configuration in an unknown encoding": Case(
        ("run.sumocfg: expected a SUMO configuration in XML",),
        {"run.sumocfg": '<?xml version="1.0" encoding="foo-8"?><configuration/>'},
    ),
    "step of zero": options('<step-length value="0"/>', "option 'step-length'", "found '0'", "0.1 s"),
    "negative step": options('<step-length value="-1"/>', "option 'step-length'", "found '-1'"),
    "step that is not a number": options('<step-length value="nan"/>', "option 'step-length'", "found 'nan'"),
    "endless step": options('<step-length value="inf"/>', "option 'step-length'", "found 'inf'"),
    "text for a time": options('<end value="soon"/>', "option 'end': expected seconds or h:m:s, found 'soon'"),
    "sublanes without end": options('<lateral-resolution value="1e-4"/>', "option 'lateral-resolution'", "0.1 to 10"),
    "unknown option": options('<step-lenght value="1"/>', "'step-lenght'", "did you mean 'step-length'?"),
    # the net
    "net with broken compression": Case(("grid.net.xml",), net=lambda net: damaged(net.encode())),
    "net cut short": Case(("grid.net.xml: not a SUMO net",), net=lambda net: net[: len(net) // 2]),
    "net of another encoding": netted('encoding="UTF-8"', 'encoding="foo-8"', "unknown encoding"),
    "net in no version": netted('<net version="[^"]*"', '<net version="abc"', "not a SUMO net", "abc"),
    "net of rails": netted(r'(<lane id="[^"]*" index="\d+") ', r'\1 allow="rail" ', "no lane that a road vehicle may"),
    "net in an unknown projection": netted(
        r'projParameter="[^"]*"', 'projParameter="+proj=no"', "projParameter", "PROJ"
    ),
    "net at no place": netted(r'netOffset="[^"]*"', 'netOffset="nan,0"', "netOffset"),
    "lane that stands still": netted(LANE + r'speed="[^"]*"', r'\1speed="-0.28"', "lane 'A0A1_0'", "-0.28 m/s"),
    "lane of endless speed": netted(LANE + r'speed="[^"]*"', r'\1speed="inf"', "lane 'A0A1_0' has a speed of inf"),
    "lane without a width": netted(LANE + "length", r'\1width="-3" length', "lane 'A0A1_0' has a width of -3.0"),
    "lane of no width": netted(LANE + "length", r'\1width="nan" length', "lane 'A0A1_0' has a width of nan"),
    "lane off the Earth": netted(LANE + r'shape="[^"]*"', r'\1shape="0,0 1e300,1e300"', "lane 'A0A1_0'", "1000 km"),
    "lane round the Earth": netted(LANE + r'shape="[^"]*"', r'\1shape="0,0 4e7,0"', "lane 'A0A1_0'", "1000 km"),
    "connection from nowhere": netted('<connection from="A0A1"', '<connection from="X"', "not a SUMO net", "'X'"),
    # parameters of vehicle types
    "unknown profile of a type": Case(
        ("cars.rou.xml: vType 'car': gpsec.sensors", "did you mean 'carla'?"),
        {"cars.rou.xml": car("gpsec.sensors", "carlo")},
    ),
}

# What is found by SUMO, or with its help.
LATE = {
    "unknown parameter of a type": Case(
        ("cars.rou.xml: vType 'car'", "'gpsec.sensor'", "'gpsec.sensors'?"),
        {"cars.rou.xml": car("gpsec.sensor", "carla")},
    ),
    "no probability": Case(
        ("cars.rou.xml: vType 'car'", "gpsec.equipped", "'often'"), {"cars.rou.xml": car("gpsec.equipped", "often")}
    ),
    "parameter of a vehicle": Case(
        ("cars.rou.xml: trip 't'", "gpsec.equipped", "expected it in a vType"),
        {
            "cars.rou.xml": routes(
                f'{CAR}<trip id="t" type="car" depart="0" from="A0A1" to="B2C2">'
                '<param key="gpsec.equipped" value="1"/></trip>'
            )
        },
    ),
    "unknown attack of a zone": drawn(zone({"attack": "drft"}), "zone 'z'", "'drft'", "did you mean 'drift'?"),
    "unknown key of a zone": drawn(zone(DRIFT | {"shaer": "1"}), "zone 'z'", "'gpsec.shaer'", "'gpsec.share'?"),
    "key of another attack": drawn(zone(DRIFT | {"bias_m": "1"}), "zone 'z'", "'gpsec.bias_m' for attack 'drift'"),
    "zone of a misspelt type": drawn(zone(DRIFT, kind="gpsec.atack"), "poly 'z'", "'gpsec.attack'", "'gpsec.atack'"),
    "text in a zone": drawn(zone(DRIFT | {"rate_mps": "x"}), "zone 'z'", "gpsec.rate_mps", "found 'x'"),
    "endless begin of a zone": drawn(zone(DRIFT | {"begin": "1e300"}), "zone 'z'", "gpsec.begin", "1e+07"),
    "zone that crosses itself": drawn(zone(DRIFT, "0,0 9,9 9,0 0,9"), "zone 'z'", "shape", "cross itself"),
    "zone without an area": drawn(zone(DRIFT, "0,0 9,9"), "zone 'z'", "three corners"),
    "multipath without its size": drawn(
        zone({}, kind=MULTIPATH), "zone 'z'", "gpsec.error_m: expected a number", "none"
    ),
    "multipath of a negative size": drawn(zone({"error_m": "-1"}, kind=MULTIPATH), "zone 'z'", "gpsec.error_m", "-1"),
    "unknown key of multipath": drawn(zone({"eror_m": "1"}, kind=MULTIPATH), "zone 'z'", "'gpsec.error_m'?"),
    "multipath of an unknown kind": drawn(
        zone({}, kind="gpsec.multpath"), "poly 'z'", "'gpsec.multpath'", "did you mean"
    ),
    "zone at no place": drawn(zone(DRIFT, "nan,0 9,9 9,0"), "zone 'z'", "shape: expected finite coordinates"),
    "point without a radius": drawn(point(DRIFT), "zone 'z'", "gpsec.radius_m", "found none"),
    "point of endless radius": drawn(point(DRIFT | {"radius_m": "1e300"}), "zone 'z'", "gpsec.radius_m", "1e+06"),
    "point at no place": drawn(point(DRIFT | {"radius_m": "9"}, x="nan"), "zone 'z'", "shape: expected finite"),
    "additional with broken compression": drawn(damaged(zone(DRIFT).encode())),
    "additional cut short": drawn(zone(DRIFT)[:40], "SUMO says"),
    "empty route file": Case(("cars.rou.xml: expected XML",), {"cars.rou.xml": ""}),
    "binary route file": Case(("cars.rou.xml: expected XML",), {"cars.rou.xml": bytes(range(256))}),
    "route over an unknown edge": Case(
        ("SUMO says", "edge 'nope'"),
        {"cars.rou.xml": routes('<trip id="t" depart="0" from="A0A1" to="nope"/>')},
    ),
    "unknown vehicle type of SUMO": Case(
        ("SUMO says", "vehicle type 'nope'"),
        {"cars.rou.xml": routes('<trip id="t" type="nope" depart="0" from="A0A1" to="B2C2"/>')},
    ),
    "type twice": Case(("SUMO says", "'car'"), {"cars.rou.xml": routes(CAR * 2 + FLOW)}),
    "begin after the end": options('<begin value="9"/><end value="5"/>', "SUMO says", "end time"),
    # what vehicles carry
    "attack of a type without a name": carried('<param key="gpsec.attack" value=""/>', "gpsec.attack", "found none"),
    "unknown attack of a type": carried('<param key="gpsec.attack" value="drft"/>', "vType 'van'", "'drift'?"),
    "spoofer of a misspelt key": carried(
        SPOOFS + '<param key="gpsec.radius" value="9"/>', "'gpsec.radius'", "radius_m"
    ),
    "spoofer without reach": carried(SPOOFS + '<param key="gpsec.radius_m" value="0"/>', "gpsec.radius_m", "found 0"),
    "spoofer that holds for ever": carried(SPOOFS + '<param key="gpsec.hold_s" value="1e9"/>', "gpsec.hold_s", "600"),
    "spoofer in the fleet": carried(
        SPOOFS + '<param key="gpsec.equipped" value="1"/>', "gpsec.equipped", "none beside"
    ),
    "spoofer with the name of a plan": Case(
        ("cars.rou.xml: vType 'drift': name: expected a name that no other plan has",),
        {"cars.rou.xml": routes(CAR + FLOW + f'<vType id="drift">{SPOOFS}</vType>')},
    ),
    "spoofers of one plan that differ": Case(
        ("cars.rou.xml: vType 'b': gpsec.share", "vType 'a'", "found '0.5'"),
        {
            "cars.rou.xml": routes(
                CAR
                + FLOW
                + f'<vType id="a">{SPOOFS}{ONE_PLAN}</vType>'
                + f'<vType id="b">{SPOOFS}{ONE_PLAN}<param key="gpsec.share" value="0.5"/></vType>'
            )
        },
    ),
    "key of a flow without an attack": Case(
        ("cars.rou.xml: flow 'f': parameter 'gpsec.begin': expected 'gpsec.attack' beside it",),
        {"cars.rou.xml": routes(CAR + FLOW.replace("/>", '><param key="gpsec.begin" value="5"/></flow>'))},
    ),
    "attack of a flow that ends before it begins": Case(
        ("cars.rou.xml: flow 'f': gpsec.end: expected later than gpsec.begin = 9, found 5",),
        {
            "cars.rou.xml": routes(
                CAR
                + FLOW.replace(
                    "/>",
                    f'>{SPOOFS}<param key="gpsec.begin" value="9"/><param key="gpsec.end" value="5"/></flow>',
                )
            )
        },
    ),
    "attack of a route": Case(
        ("cars.rou.xml: route 'r': parameter 'gpsec.attack': expected it in a poly",),
        {"cars.rou.xml": routes(CAR + FLOW + f'<route id="r" edges="A0A1">{SPOOFS}</route>')},
    ),
    "attack in a file that is included": Case(
        ("s/van.add.xml: vType 'van'", "gpsec.radius_m", "found 'far'"),
        {
            "more.add.xml": '<additional><include href="van.add.xml"/></additional>',
            "van.add.xml": f'<additional><vType id="van">{SPOOFS}<param key="gpsec.radius_m" value="far"/></vType>'
            "</additional>",
        },
    ),
    "long words of SUMO": Case(
        ("run.sumocfg: SUMO says: ", "'xx"), {"cars.rou.xml": routes(FLOW.replace('"car"', f'"{LONG}"'))}
    ),
    "zone that is not drawn": Case(
        ("scenario 's'", "plans[0]: zone", "'school'", "no zone is drawn"),
        {"gpsec.toml": '[[plans]]\nattack = "drift"\nzone = "school"'},
    ),
}


def refused(here: Path, case: Case, net: str, capsys: pytest.CaptureFixture[str]) -> None:
    lay_out(here, net, case)
    before = sorted(here.rglob("*"))
    assert cli.main(list(case.arguments)) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("gpsec: error: ")
    assert captured.err.count("\n") == 1, captured.err
    assert captured.err[:-1].isprintable()
    assert len(captured.err) < 1500
    assert captured.out == ""
    assert all(fragment in captured.err for fragment in case.says), captured.err
    assert sorted(here.rglob("*")) == before


@pytest.mark.parametrize("name", EARLY)
def test_refused_before_sumo(name: str, here: Path, grid: str, capsys: pytest.CaptureFixture[str]) -> None:
    refused(here, EARLY[name], grid, capsys)


@pytest.mark.parametrize("name", LATE)
def test_refused_with_sumo(
    name: str, here: Path, grid: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote, "RemoteSession", SumoSession)  # in this process, which is faster
    refused(here, LATE[name], grid, capsys)


def test_what_a_windows_editor_writes_is_read(here: Path, grid: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote, "RemoteSession", SumoSession)
    lay_out(here, grid, Case((), {"gpsec.toml": b"\xef\xbb\xbfseed = 2\r\n"}))
    assert cli.main(["check", "s"]) == 0


def test_folder_that_is_gone(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gone = here / "gone"
    gone.mkdir()
    os.chdir(gone)
    shutil.rmtree(gone)
    assert cli.main(["run", "x.sumocfg"]) == 2
    assert capsys.readouterr().err == "gpsec: error: the current folder is gone; go to another one\n"


def test_what_sumo_warns_of_is_shown(
    here: Path, grid: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote, "RemoteSession", SumoSession)
    drawn = '<poly id="old town" type="building" shape="0,0 1,0 1,1"/>'
    lay_out(here, grid, Case((), {"more.add.xml": f"<additional>{drawn}</additional>"}))
    assert cli.main(["check", "s"]) == 0
    ok, warning = capsys.readouterr().out.splitlines()
    assert ok.startswith("s: ok")
    assert warning == "  SUMO warns: Invalid characters for Poly ID 'old town'"
