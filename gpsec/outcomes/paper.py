"""The published figures that ours are set beside.

Chen, Liu, Li and Wang, "GPS Attack Detection and Mitigation for Safe Autonomous Driving using Image and Map based
Lateral Direction PublishedRmse": averages of repeated runs.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class PublishedScores:
    """A cell of Table I: precision, recall, F1 and mean delay."""

    precision: float
    recall: float
    f1: float
    delay_s: float


@dataclass(frozen=True)
class PublishedRmse:
    """One of Tables II to IV: RMSE in x, y and xy, with and without the mitigation.

    Attributes:
        table: its number and set-up.
        scenarios: ours that are like it, where driven with `profile`.
        profile: ours that is like its sensors and map.
        mitigated_m, undefended_m: RMSE in x, y, xy.

    """

    table: str
    scenarios: tuple[str, ...]
    profile: str
    mitigated_m: tuple[float, float, float]
    undefended_m: tuple[float, float, float]


TABLE_I = {
    ("constant_bias", "cusum"): PublishedScores(0.82, 0.95, 0.88, 0.2),
    ("constant_bias", "isolation_forest"): PublishedScores(0.93, 0.95, 0.94, 0.2),
    ("constant_bias", "lstm"): PublishedScores(0.98, 1.0, 0.99, 0.0),
    ("stealth", "cusum"): PublishedScores(0.73, 0.85, 0.79, 0.9),
    ("stealth", "isolation_forest"): PublishedScores(0.94, 0.87, 0.91, 0.8),
    ("stealth", "lstm"): PublishedScores(0.98, 0.90, 0.94, 0.6),
}

TABLES_II_TO_IV = (
    PublishedRmse("II (DSD)", ("slow_curve",), "dsd", (0.012, 0.025, 0.032), (1.52, 1.54, 2.16)),
    PublishedRmse("III (CARLA)", ("sharp_turns",), "carla", (0.240, 0.170, 0.358), (2.410, 2.380, 4.789)),
    PublishedRmse("IV (nuScenes)", ("slow_curve", "highway"), "nuscenes", (0.316, 0.137, 0.312), (2.062, 2.049, 2.908)),
)

# Ours that the paper's row of a detector is set beside, too.
STANDS_FOR = {"lstm_glr": "lstm"}


def detection_like(attack: str, detector: str) -> PublishedScores | None:
    """Return the cell of Table I for a detector, or for the one that it stands for, if there is one."""
    return TABLE_I.get((attack, STANDS_FOR.get(detector, detector)))


def localization_like(scenario: str, profile: str) -> PublishedRmse | None:
    """Return the table whose set-up is like ours, if there is one."""
    for table in TABLES_II_TO_IV:
        if scenario in table.scenarios and profile == table.profile:
            return table
    return None
