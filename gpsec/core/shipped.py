"""The scenarios that come with gpsec, and the nets that they refer to.

Their one source are the folders ``scenarios`` and ``sumo_nets`` at the top of a checkout. A wheel has copies of both,
side by side as they are there, so that paths between them hold.
"""

from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]


def home() -> Path:
    """Return the folder that has ``scenarios`` and ``sumo_nets``: the checkout's top, or the data of the package."""
    packed = PACKAGE / "data"
    return packed if packed.is_dir() else PACKAGE.parent


def scenarios() -> Path:
    """Return the folder of the scenarios that come with gpsec."""
    return home() / "scenarios"
