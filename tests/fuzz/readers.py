"""What gpsec reads, as it is in order, and what each reader is asked to do with it when it is not."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from json import dumps
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from gpsec import cli
from gpsec.detection import models
from gpsec.hdmap.map import load_map
from gpsec.imaging.pictures.calibration import read_calibration
from gpsec.imaging.pictures.camera import RoadCamera
from gpsec.replay.fcd import read_clock, steps
from gpsec.replay.figures import error_table
from gpsec.replay.prepare import lay
from gpsec.replay.readers import read_drive
from gpsec.report.log_page import write_log_page
from gpsec.sensors.registry import PROFILES
from gpsec.traffic.recording import RecordedTraffic
from gpsec.traffic.recordingfile import load_recording, on_net
from gpsec.types.paint import read_paint
from gpsec.types.tapes import Tape, read_tape, write_tape
from tests.bad_input.worlds import CAR, FLOW, config, routes, zone
from tests.opendrive.maps import TWO_WAY, document, lane, road, section
from tests.openstreetmap.maps import CROSSING
from tests.replay.logs import table
from tests.replay.test_readers import FCD

from . import mutators
from .material import Material
from .mutators import Mutate

TOML = """
name = "fuzzed"
sumocfg = "run.sumocfg"
duration_s = 20.0
seed = 3

[fleet]
profile = "carla"
equipped_share = 0.8
settle_s = 2.0

[traffic]
step_s = 0.1

[detection]
rates = ["1e-3/sample"]

[[defences]]
detector = "cusum"
response = "ukf"

[[defences]]
detector = "isolation_forest"
response = "ukf5_rollback"

[[plans]]
attack = "constant_bias"
bias_m = 2.4
share = 0.5
start_after_s = [5.0, 10.0]
duration_s = [5.0, 10.0]
"""
TYPES = '<vType id="van" accel="2.0"><param key="gpsec.equipped" value="0.5"/></vType>'
VEHICLES = '<vehicle id="v" type="van" depart="1.0"><route edges="A0A1 A1A2"/></vehicle>'
OPTIONS = (
    '<time><end value="30"/><step-length value="0.1"/></time><processing><lateral-resolution value="0.8"/></processing>'
)
ZONE = zone({"attack": "constant_bias", "bias_m": "2.0", "share": "1.0"})
SPIRAL = (
    '<geometry s="0" x="0" y="0" hdg="0" length="40"><spiral curvStart="0" curvEnd="0.02"/></geometry>'
    '<geometry s="40" x="39.4" y="4.2" hdg="0.4" length="60"><arc curvature="0.02"/></geometry>'
)
MAP = document(
    road(TWO_WAY),
    road(section(right=lane(-1) + lane(-2, kind="shoulder")), geometry=SPIRAL, number="2"),
)
LINES = b"lane,begin_m,end_m,left,right\na_0,0,12.5,1,0\na_0,12.5,40,1,1\n"
FIGURES = (
    "scenario,sensor,axis,figure,unit,value,value_lo,value_hi,n,profile_says,key\n"
    "drive,gnss,across,√structure 0.1 s,m,0.01,0.009,0.011,400,0.28,gnss\n"
    "drive,odometer,,scale - 1,,0.01,,,400,0.01,odometer.scale_ratio\n"
).encode()


CALIBRATION = dumps(asdict(RoadCamera())).encode()


@dataclass(frozen=True)
class Reader:
    """Something that reads files of a user.

    Attributes:
        read: is called in the folder of the files; returns an exit status.
        files: what is in order, by path.
        damaged: what is changed of it, each with the way of changing.
    """

    read: Callable[[], int]
    files: Mapping[str, bytes]
    damaged: Mapping[str, Mutate] = field(default_factory=dict)


def command(*arguments: str) -> Callable[[], int]:
    """Return a call of the command line."""
    return partial(cli.main, list(arguments))


def readers(material: Material) -> dict[str, Reader]:
    """Return all readers."""
    world = {
        "s/gpsec.toml": TOML.encode(),
        "s/run.sumocfg": config(OPTIONS).encode(),
        "s/grid.net.xml": material.net,
        "s/cars.rou.xml": routes(CAR + TYPES + VEHICLES + FLOW).encode(),
        "s/more.add.xml": ZONE.encode(),
    }
    check = command("check", "s")
    import_ = command("import", "map.xodr", "--out", "map.net.xml")
    demand = command("demand", "grid.net.xml", "--out", "made", "--duration", "20")
    bundled = _bundled()
    run = {f"r/{name}": content for name, content in material.run.items()}
    other = {f"o/{name}": content for name, content in material.run.items()}
    return {
        "toml": Reader(check, world, {"s/gpsec.toml": mutators.words}),
        "set": Reader(_set, world | {"set": b"fleet.profile=carla"}, {"set": mutators.words}),
        "sumocfg": Reader(check, world, {"s/run.sumocfg": mutators.xml}),
        "net": Reader(check, world, {"s/grid.net.xml": mutators.xml}),
        "routes": Reader(check, world, {"s/cars.rou.xml": mutators.xml}),
        "additional": Reader(check, world, {"s/more.add.xml": mutators.xml}),
        "opendrive": Reader(import_, {"map.xodr": MAP.encode()}, {"map.xodr": mutators.xml}),
        "openstreetmap": Reader(
            command("import", "map.osm", "--out", "map.net.xml"),
            {"map.osm": CROSSING.encode()},
            {"map.osm": mutators.xml},
        ),
        "demand": Reader(demand, {"grid.net.xml": material.net}, {"grid.net.xml": mutators.xml}),
        "recording": Reader(
            _replay,
            {"traffic.npz": material.recording, "grid.net.xml": material.net},
            {"traffic.npz": mutators.arrays},
        ),
        "log": Reader(_log, {"drive.csv": table().to_csv(index=False).encode()}, {"drive.csv": mutators.table}),
        "fcd": Reader(_fcd, {"fcd.xml": FCD.encode()}, {"fcd.xml": mutators.xml}),
        "lines": Reader(_lines, {"net.paint.csv": LINES}, {"net.paint.csv": mutators.table}),
        "log page": Reader(_log_page, {"errors.csv": FIGURES}, {"errors.csv": mutators.table}),
        "tape": Reader(_tape, {"camera.npz": _a_tape()}, {"camera.npz": mutators.arrays}),
        "calibration": Reader(_calibration, {"c.json": CALIBRATION}, {"c.json": mutators.json_}),
        "models": Reader(_models, bundled, _ways(bundled)),
        "report": Reader(command("report", "r", "--geojson"), run, _ways(run)),
        "comparison": Reader(command("report", "r", "o"), {**run, **other}, _ways(run)),
        "trace": Reader(command("trace", "r", "f.0"), run, _ways(run)),
    }


def _log() -> int:
    laid = lay(read_drive(Path("drive.csv"), "csv"))
    error_table(laid.log, "drive", PROFILES["consumer"])
    return 0 if len(laid.drive) else 1


def _fcd() -> int:
    read_clock(Path("fcd.xml"))
    return 0 if all(len(seen) >= 0 for _, seen in steps(Path("fcd.xml"))) else 1


def _lines() -> int:
    return 0 if len(read_paint(Path("net.paint.csv"))) >= 0 else 1


def _log_page() -> int:
    return 0 if write_log_page(Path.cwd()) else 1


def _tape() -> int:
    return 0 if len(read_tape(Path("camera.npz"))[0].missing) else 1


def _a_tape() -> bytes:
    errors, sigma_m = np.arange(80.0).reshape(20, 4), np.full(20, 0.1)
    missing, piece = np.zeros(20, np.bool_), np.array([0, 8])
    tape = Tape("camera", 10.0, errors, missing, sigma_m, piece, np.zeros((2, 4)), "rain", {"made_by": "a test"})
    with TemporaryDirectory() as folder:
        write_tape(tape, Path(folder) / "camera.npz")
        return (Path(folder) / "camera.npz").read_bytes()


def _calibration() -> int:
    return 0 if read_calibration(Path("c.json")).width > 0 else 1


def _set() -> int:
    text = Path("set").read_text(encoding="utf-8", errors="replace")
    return cli.main(["check", "s", "--set", text])


def _replay() -> int:
    net = Path("grid.net.xml")
    recording = load_recording(Path("traffic.npz"), on_net(net, len(load_map(net, ()).lane_ids)))
    traffic = RecordedTraffic(recording)
    return 0 if all(len(frame.rows) >= 0 for frame in traffic.frames()) else 1


def _models() -> int:
    loaded = models.load_models(Path.cwd())
    names = ("chi_square", "cusum", "isolation_forest", "lstm_glr")
    detectors = models.build_detectors(names, ["carla"], "tracked", loaded)
    models.thresholds_for([(name, "1e-3/sample") for name in names], ["carla"], "tracked", loaded)
    return 0 if len(detectors) == len(names) else 1


def _bundled() -> dict[str, bytes]:
    folder = Path(models.__file__).parents[1] / "models"
    return {name: (folder / name).read_bytes() for name in ("carla-tracked.npz", "thresholds.json", "provenance.json")}


def _ways(files: Mapping[str, bytes]) -> dict[str, Mutate]:
    ways = {".csv": mutators.table, ".npz": mutators.arrays, ".json": mutators.json_, ".geojson": mutators.json_}
    return {name: ways[Path(name).suffix] for name in files if Path(name).suffix in ways}
