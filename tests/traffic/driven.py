"""A controlled simulation in which vehicles are called by their SUMO id."""

import numpy as np
import sumolib

from gpsec.traffic.commands import CommandKind, Commands
from gpsec.traffic.controlled import ControlledSession
from gpsec.traffic.options import resolve_options

CAR = '<vType id="car" sigma="0.5" length="4" minGap="2"/><vType id="slow" maxSpeed="5" length="4"/>'
LONG = '<route id="long" edges="A0B0 B0C0 C0C1 C1C2"/><route id="left" edges="A0B0 B0B1 B1B2"/>'


def everybody(departure):
    return True


def nobody(departure):
    return False


def steer(rows, lateral_m=0.0, brake_mps2=0.0, order=CommandKind.STEER, others=False):
    count = len(rows)
    return Commands(
        np.array(rows, np.int32),
        np.full(count, others),
        np.full(count, order, np.int32),
        np.broadcast_to(np.asarray(lateral_m, float), (count,)).copy(),
        np.broadcast_to(np.asarray(brake_mps2, float), (count,)).copy(),
    )


def numbers_of(net):
    """Return a number for each lane of a net file, by its name."""
    edges = sumolib.net.readNet(str(net), withInternal=True).getEdges()
    return {lane.getID(): at for at, lane in enumerate(lane for edge in edges for lane in edge.getLanes())}


def configured(net, routes):
    """Write routes beside a net file; return the configuration of both."""
    (net.parent / "cars.rou.xml").write_text(f"<routes>{CAR}{routes}</routes>")
    config = net.parent / "run.sumocfg"
    inputs = f'<net-file value="{net.name}"/><route-files value="cars.rou.xml"/>'
    config.write_text(f"<configuration><input>{inputs}</input></configuration>")
    return config


class Driven:
    """A controlled session in which everybody is called by their SUMO id."""

    def __init__(self, config, lanes, equip=everybody, **asked):
        self.session = ControlledSession(resolve_options(config, seed=1, closed_loop=True, **asked), lanes, equip)
        self.row, self.place, self.lane, self.seen = {}, {}, {}, []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.session.close()

    def frames(self, seconds):
        names = {}
        for frame in self.session.frames(seconds):
            for row in frame.left:
                self.row.pop(names.pop(row))
            for departure in frame.departures:
                names[departure.row] = departure.sumo_id
                self.row[departure.sumo_id] = departure.row
            self.place = {names[r]: p for r, p in zip(frame.rows.tolist(), frame.front_m, strict=True)}
            yield frame

    def steer(self, name, lateral_m=0.0, brake_mps2=0.0):
        if name in self.row:
            self.session.command(steer([self.row[name]], lateral_m, brake_mps2))
