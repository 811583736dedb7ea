"""What lanes and edges are called, and how they are: the columns of a place in the tables."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.hdmap.arrays import LaneSides

# Columns of `Streets.columns`.
PLACE = ("edge", "lane", "speed_mps", "lane_width_m", "lanes", "in_junction")


class Streets(NamedTuple):
    """What lanes are called and how they are, for tables.

    Attributes:
        lane_id: (L,) SUMO's ids.
        width_m: (L,) of the lane.
        internal: (L,) inside a junction.
        edge: (L,) number of its edge.
        edge_id: (E,) ids of the edges.
        lanes: (E,) lanes of the edge that vehicles may drive on.
    """

    lane_id: NDArray[Any]
    width_m: Floats
    internal: Flags
    edge: Ints
    edge_id: NDArray[Any]
    lanes: Ints

    @classmethod
    def on(cls, lane_ids: Sequence[str], sides: LaneSides) -> "Streets":
        """Return the streets of a map."""
        edge, names = pd.factorize(np.array([name.rpartition("_")[0] for name in lane_ids], object))
        return cls(
            np.array(lane_ids, object),
            sides.width_m,
            sides.internal,
            edge.astype(np.int32),
            np.asarray(names, object),
            np.bincount(edge, minlength=len(names)).astype(np.int32),
        )

    def columns(self, prefix: str, lane: Ints, speed_mps: Floats) -> dict[str, Any]:
        """Return the columns of a place on (…,) lanes, -1 where there was none: empty then."""
        known = lane >= 0
        at = np.maximum(lane, 0)
        edge = self.edge[at]
        return {
            f"{prefix}edge": _texts(self.edge_id[edge], known),
            f"{prefix}lane": _texts(self.lane_id[at], known),
            f"{prefix}speed_mps": np.where(known, speed_mps, np.nan),
            f"{prefix}lane_width_m": np.where(known, self.width_m[at], np.nan),
            f"{prefix}lanes": np.where(known, self.lanes[edge], np.nan),
            f"{prefix}in_junction": _texts(self.internal[at], known),
        }


def _texts(values: NDArray[Any], known: Flags) -> NDArray[Any]:
    """Return values as pandas holds them where `known`, and nothing elsewhere."""
    found = np.full(values.shape, None, object)
    found[known] = values[known]
    return found
