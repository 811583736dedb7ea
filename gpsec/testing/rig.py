"""A few vehicles on one lane, and the localization that follows them, without a pipeline."""

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.filters.noise import FilterNoise, noise_table
from gpsec.hdmap.arrays import MapView
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.hdmap.search import TRACKED
from gpsec.localization.registry import RESPONSES
from gpsec.localization.rejoin import SwitchSettings
from gpsec.localization.responses import Response
from gpsec.localization.state import Branches
from gpsec.localization.switch import Localization
from gpsec.localization.world import World
from gpsec.testing.contract import STEP_S
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

RIG_FIGURES = FilterNoise(
    gnss_white_m=0.1,
    gnss_bias_m=0.05,
    gnss_bias_tau_s=10.0,
    gnss_period_s=0.1,
    odometer_white_mps=0.05,
    odometer_scale=0.01,
    gyro_white_rps=0.002,
    gyro_bias_rps=1e-4,
    heading_rad=0.01,
    residual_m=0.15,
    gyro_bias_tau_s=100.0,
    camera_white_m=0.06,
    camera_slope=0.01,
    camera_slope_correlation=-0.5,
    camera_bias_m=0.04,
    camera_bias_tau_s=10.0,
    camera_mount_m=0.03,
    camera_period_s=0.1,
    gyro_latency_s=0.0,
)
ONE_THREAD = Threads(1)
_STRAIGHT_NET = """<net version="1.20">
<location netOffset="0,0" convBoundary="0,0,5000,0" origBoundary="0,0,5000,0" projParameter="!"/>
<edge id="ab" from="a" to="b">
<lane id="ab_0" index="0" speed="30" length="5000" width="3.2" shape="0,0 5000,0"/>
</edge>
<junction id="a" type="dead_end" x="0" y="0" incLanes="" intLanes="" shape="0,0"/>
<junction id="b" type="dead_end" x="5000" y="0" incLanes="ab_0" intLanes="" shape="5000,0"/>
</net>"""


@cache
def straight_road() -> HDMap:
    """Return the map of one lane of 5 km, due east along y = 0."""
    with TemporaryDirectory() as folder:
        net = Path(folder) / "straight.net.xml"
        net.write_text(_STRAIGHT_NET)
        return compile_map(net, ())


@dataclass
class Rig:
    """M tracks of as many vehicles that drive east, each under all responses.

    Attributes:
        hd_map: the road.
        responses: names of the responses; the alarm has one column for each.
        count: M.
        speed_mps: of the vehicles.
        figures: of their sensors.
        settings: when GNSS is given up and taken back.
        lane: that they are on.
        others: responses that are not registered, by name.
        world, localization, state: what follows the vehicles.
        vehicles, seen, tracks, alarm, rows: what it is given.
    """

    hd_map: HDMap
    responses: tuple[str, ...] = tuple(RESPONSES)
    count: int = 1
    speed_mps: float = 10.0
    figures: FilterNoise[float] = RIG_FIGURES
    settings: SwitchSettings = field(default_factory=SwitchSettings)
    lane: int = 0
    others: dict[str, type[Response]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        layer = np.zeros(1, np.int32)
        table = noise_table([self.figures])
        self.world = World(MapView(self.hd_map.lanes, self.hd_map.index, TRACKED, layer), table, STEP_S)
        kinds = {**RESPONSES, **self.others}
        parts = {name: kinds[name]() for name in self.responses}
        columns = np.arange(len(self.responses), dtype=np.int32)
        defences = [parts[name] for name in self.responses]
        self.localization = Localization(columns, defences, self.world, self.settings)
        self.vehicles, self.seen = Table(Vehicles, self.count).now, Table(Measurements, self.count).now
        self.tracks = Table(Tracks, self.count).now
        self.rows = np.arange(self.count, dtype=np.int32)
        self.state = self.localization.new_state(self.count)
        self.state.reset(self.rows)
        self.state.history.grow(self.count)
        self.alarm = np.zeros((self.count, len(self.responses)), np.bool_)
        self.tracks.vehicle[:] = np.arange(self.count)
        self.vehicles.lane[:] = self.tracks.lane[:] = self.lane
        self.tracks.lane_known[:] = True
        self.vehicles.rear_m[:] = self.hd_map.centre_line(self.lane)[0]
        self.seen.speed_mps[:] = self.vehicles.speed_mps[:] = self.speed_mps
        self.seen.camera_sigma_m[:] = 0.08

    def column(self, response: str) -> int:
        """Return the defence with a response."""
        return self.responses.index(response)

    def step(
        self,
        bias_m: tuple[float, float] = (0.0, 0.0),
        fix: bool = True,
        camera: bool = True,
        alarm: bool = False,
        residual_m: float | None = None,
    ) -> None:
        """Drive one step; sensors are perfect, the fix is displaced by `bias_m`, and so is its residual."""
        self.vehicles.rear_m[:, 0] += self.speed_mps * STEP_S
        self.tracks.fix_m[:] = self.vehicles.rear_m + np.array(bias_m)
        self.tracks.fix_valid[:] = fix
        self.tracks.paired_m[:] = self.tracks.fix_m
        self.seen.camera_valid[:] = camera
        self.tracks.residual_valid[:] = fix and camera
        self.tracks.residual_m[:] = -bias_m[1] if residual_m is None else residual_m
        self.alarm[:] = alarm
        self.localize(self.rows)

    def localize(self, rows: Ints) -> None:
        """Let the localization take a step with some tracks."""
        tracks, vehicles, seen = self.tracks, self.vehicles, self.seen
        self.localization.propagate(self.state, rows, tracks, vehicles, seen, self.alarm, ONE_THREAD)
        self.localization.correct(self.state, rows, tracks, vehicles, seen, ONE_THREAD)

    def filters(self, response: str) -> Branches:
        """Return a copy of the filters of a defence, one for each track."""
        branches, row = self.state.of(self.column(response))
        return Branches._make(array[row] for array in branches)

    def filter(self, response: str) -> Branches:
        """Return the filter of a defence of the first track itself, which it may share with other defences."""
        branches, row = self.state.of(self.column(response))
        return Branches._make(array[row[0]] for array in branches)

    def error_m(self, response: str) -> Floats:
        """Return (M, 2) estimates minus truth."""
        error: Floats = self.filters(response).mean[:, :2] - self.vehicles.rear_m
        return error

    def isolated(self, response: str) -> bool:
        """Return whether a defence of the first track has isolated GNSS."""
        return bool(self.filters(response).response[0] >= 0)

    def steps_until(self, isolated: bool, response: str = "ukf", limit: int = 400, **step: object) -> int:
        """Return the number of steps until the first vehicle is (not) isolated."""
        for number in range(1, limit + 1):
            self.step(**step)  # type: ignore[arg-type]
            if self.isolated(response) == isolated:
                return number
        raise AssertionError(f"not within {limit} steps")


def rig_figures(**changes: float) -> FilterNoise[float]:
    """Return `RIG_FIGURES` with changes."""
    return RIG_FIGURES._replace(**changes)
