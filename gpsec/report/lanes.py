"""The table of a report on which lane vehicles believed to be on."""

from gpsec.report.figure_data import group_name
from gpsec.report.formatting import EMPTY
from gpsec.report.tables import ReportTable, TableCell, TableRow, by_group
from gpsec.running.results import Results

_SHARES = {
    "right on roads": "road_right_share",
    "right where the camera sees": "seen_right_share",
    "right in junctions": "junction_right_share",
    "right at forks": "fork_right_share",
    "lane change right within 0.1 s": "right_within_100_ms_share",
    "within 0.5 s": "right_within_500_ms_share",
    "unknown": "unknown_share",
    "unmatched": "unmatched_share",
}
_CAPTION = {
    "tracked": "Shares of steps. Vehicles track their lane by their own sensors.",
    "nearest": "Shares of steps. Each fix is matched to the lane that is nearest to it, as in the paper.",
    "oracle": "Vehicles are told their lane by the simulator: a bound, which no vehicle reaches.",
}


def association_tables(run: Results) -> list[ReportTable]:
    """Return how often the believed lane was right: attack × phase."""
    made = []
    for (scenario, profile), rows in by_group(run.association):
        lines = []
        for row in rows:
            # A step in a hundred thousand counts here.
            shares = [row[name] for name in _SHARES.values()]
            cells = [TableCell(EMPTY if share != share else f"{100.0 * share:.3f} %") for share in shares]
            lines.append(TableRow(row["attack"], row["phase"], cells))
        caption = _CAPTION.get(str(rows[0]["association"]), "Shares of steps.")
        made.append(ReportTable(group_name(scenario, profile), ["attack", "phase", *_SHARES], lines, caption))
    return made
