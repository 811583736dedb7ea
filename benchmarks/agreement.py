"""Do vehicles truly go where the open loop says they would? ``python -m benchmarks.agreement results/closed-loop``."""

import argparse
import sys
from pathlib import Path

import pandas as pd

from gpsec.core.errors import GpsecError
from gpsec.outcomes.naming import scenario_of_world
from gpsec.outcomes.tables import read_table
from gpsec.types.constants import UNDEFENDED

OUT = ("out_of_lane", "wrong_way", "off_road")
# The steering follows the estimate by at most so much later: acceptance of the closed loop.
LAG_S = 1.2
SPLIT = ("the same", "crashed", "stood", "over before the steering followed", "remainder")


def split(events: pd.DataFrame) -> pd.Series:
    """Return for each of the undefended `events` of closed worlds how truth and open loop compare, one of `SPLIT`.

    The open loop goes by the error of the estimate. Both are the same where both leave the lane, or neither does. An
    attack is over too soon where the error is beyond the line for less than `LAG_S` before its end.
    """
    said, is_true = events["open_loop_outcome"].isin(OUT), events["true_outcome"].isin(OUT)
    left_s = events["attack_seconds"] - events["time_to_outcome_s"]
    kind = pd.Series(SPLIT[4], index=events.index)
    kind[said & (left_s < LAG_S)] = SPLIT[3]
    kind[events["stood_s"] > 0.0] = SPLIT[2]
    kind[events["crash_s"].notna()] = SPLIT[1]
    kind[said == is_true] = SPLIT[0]
    return kind


def main(arguments: list[str] | None = None) -> int:
    """Print the split for each net; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.agreement", description=__doc__)
    parser.add_argument("folder", type=Path, help="of a run in closed loop with an undefended world")
    folder = parser.parse_args(arguments).folder
    try:
        events, worlds = read_table(folder, "events"), read_table(folder, "worlds")
    except GpsecError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.status
    undefended = set(worlds.loc[worlds["defence"] == UNDEFENDED, "scenario"])
    events = events[(events["defence"] == UNDEFENDED) & events["scenario"].isin(undefended)]
    for net, mine in events.groupby(events["scenario"].map(scenario_of_world)):
        kinds = split(mine).value_counts()
        free = mine[(mine["stood_s"] == 0.0) & mine["crash_s"].isna()]
        same = free["open_loop_outcome"].isin(OUT) == free["true_outcome"].isin(OUT)
        alike = free[free["true_outcome"] == free["open_loop_outcome"]]
        later_s = alike["true_outcome_s"] - alike["time_to_outcome_s"]
        print(f"{net}: {len(mine)} attacked; " + ", ".join(f"{kind} {kinds.get(kind, 0)}" for kind in SPLIT))
        print(f"  of {len(free)} that drove freely {100 * same.mean():.1f} % the same, {later_s.median():.1f} s later")
    return 0


if __name__ == "__main__":
    sys.exit(main())
