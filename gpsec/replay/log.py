"""A drive as its sensors wrote it down, whatever file it came from."""

from dataclasses import dataclass, field
from pathlib import Path

from gpsec.core.arrays import Floats


@dataclass(frozen=True)
class Samples:
    """What one sensor wrote down.

    Attributes:
        time_s: (n,) of the log's clock, ascending.
        numbers: (n, k).
    """

    time_s: Floats
    numbers: Floats


@dataclass(frozen=True)
class Fixes:
    """What the receiver wrote down.

    Attributes:
        time_s: (n,) when each fix arrived, ascending.
        valid_s: (n,) when each was true, by the receiver's own clock; `time_s` where it does not say.
        position_m: (n, 2) east and north in the frame of the pose.
    """

    time_s: Floats
    valid_s: Floats
    position_m: Floats


@dataclass(frozen=True)
class DriveLog:
    """One vehicle's drive. Whatever is None was not written down, and `notes` says so.

    Attributes:
        source: file or folder.
        reader: that read it.
        projection: of the frame, a PROJ string, "!" where it lies nowhere on the Earth.
        pose: east and north (m) and yaw (rad) of the point that stands for the rear axle: the reference.
        fixes: of the receiver.
        speed: of the wheels (m/s).
        yaw_rate: of the gyro (rad/s), counter-clockwise.
        heading: (rad), counter-clockwise from east.
        lane: C0 … C3 of the camera (Eq 1), and the standard deviation that it states for C0, 0 where it states none.
        notes: what is missing and what was taken for it, one sentence each.
    """

    source: Path
    reader: str
    projection: str
    pose: Samples
    fixes: Fixes | None = None
    speed: Samples | None = None
    yaw_rate: Samples | None = None
    heading: Samples | None = None
    lane: Samples | None = None
    notes: tuple[str, ...] = field(default=())

    def sensors(self) -> dict[str, Samples]:
        """Return what there is of speed, yaw rate, heading and lane, by name."""
        named = {"speed": self.speed, "yaw_rate": self.yaw_rate, "heading": self.heading, "lane": self.lane}
        return {name: samples for name, samples in named.items() if samples is not None}


NO_PROJECTION = "!"


def projection_at(lon_deg: float, lat_deg: float) -> str:
    """Return a PROJ string of a metric frame around a place on the Earth, east and north."""
    return f"+proj=tmerc +lat_0={lat_deg:.7f} +lon_0={lon_deg:.7f} +datum=WGS84 +units=m"
