"""The check of a net against the map it was made from: figures for each lane, and for all of it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.core.errors import shown
from gpsec.opendrive.compare import match_lanes
from gpsec.opendrive.lanes import NARROWEST_M, CentreLine
from gpsec.opendrive.netfile import NetLane

# Not that of the new shapes, whose points would be compared with themselves.
CHECK_SPACING_M = 0.9
MOST_LOST_SHARE = 0.03
"""Of the map's lane length, that a net may be without."""
# A lane with less than this share of its points beside a lane of the net is lost.
_LEAST_MATCHED_SHARE = 0.5


@dataclass(frozen=True)
class MapDeviation:
    """How far net and map lie apart across the lane, over a number of points about `CHECK_SPACING_M` apart.

    Attributes:
        points: that are wide enough to drive.
        unmatched_share: of these, without a lane of the net beside them.
        median_m, p95_m, largest_m: of the distance across the lane, None without a matched point.
        mean_m: signed, positive where the net lies to the left.
    """

    points: int
    unmatched_share: float
    median_m: float | None
    p95_m: float | None
    largest_m: float | None
    mean_m: float | None


@dataclass(frozen=True)
class Check:
    """The result of a check.

    Attributes:
        lines: the map's lanes.
        by_lane: figures of each.
        overall: figures of all points.
        narrow_share: of the map's lane length, narrower than `NARROWEST_M` and left out.
        across_m: of each lane, (n,) distances at its points, nan where nothing was compared.
        over_share: by sensor profile, the share of points at which the distance alone would raise an alarm.
        alarm_m: by sensor profile, the steady residual that raises an alarm.
        lost: names of the map's lanes that the net has not, or less than half of.
    """

    lines: list[CentreLine]
    by_lane: list[MapDeviation]
    overall: MapDeviation
    narrow_share: float
    across_m: list[Floats]
    over_share: dict[str, float]
    alarm_m: dict[str, float]
    lost: tuple[str, ...]

    @property
    def incomplete(self) -> bool:
        """Whether the net lacks more of the map than `MOST_LOST_SHARE`."""
        return self.overall.unmatched_share > MOST_LOST_SHARE


def check_lanes(lines: list[CentreLine], lanes: list[NetLane], alarm_m: Mapping[str, float]) -> Check:
    """Compare the lanes of a net with the map's.

    Args:
        lines: the map's lane centres.
        lanes: of the net.
        alarm_m: by sensor profile, the steady residual that raises an alarm.
    """
    found = match_lanes(lines, lanes)
    wide = np.concatenate([line.width_m for line in lines]) >= NARROWEST_M
    ends = np.cumsum([len(line.points_m) for line in lines])[:-1]
    matched = found.matched & wide
    across = np.where(matched, found.across_m, np.nan)
    distance = np.abs(found.across_m[matched])
    by_lane = [
        _figures(*piece)
        for piece in zip(*(np.split(values, ends) for values in (found.across_m, matched, wide)), strict=True)
    ]
    return Check(
        lines,
        by_lane,
        _figures(found.across_m, matched, wide),
        float(1.0 - wide.mean()),
        np.split(across, ends),
        {name: float((distance > level).mean()) if len(distance) else 0.0 for name, level in alarm_m.items()},
        dict(alarm_m),
        tuple(_name(line) for line, figures in zip(lines, by_lane, strict=True) if _is_lost(figures)),
    )


def _is_lost(figures: MapDeviation) -> bool:
    return figures.points > 1 and figures.unmatched_share > 1.0 - _LEAST_MATCHED_SHARE


def _name(line: CentreLine) -> str:
    begin, end = line.station_m.min(), line.station_m.max()
    return f"lane {line.lane_id} of road '{shown(line.road_id)}' (s={begin:.0f} to {end:.0f} m)"


def _figures(across: Floats, matched: Flags, wide: Flags) -> MapDeviation:
    count = int(wide.sum())
    unmatched = 1.0 - matched.sum() / count if count else 0.0
    if not matched.any():
        return MapDeviation(count, float(unmatched), None, None, None, None)
    distance = np.abs(across[matched])
    return MapDeviation(
        count,
        float(unmatched),
        float(np.median(distance)),
        float(np.percentile(distance, 95.0)),
        float(distance.max()),
        float(across[matched].mean()),
    )
