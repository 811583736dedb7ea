"""Evaluates GPS-spoofing attacks on automated vehicles at the scale of SUMO traffic.

``gpsec.run("town", "results/town")`` runs a scenario and returns its results; `load`, `check`, `read_scenario` and
`train` are beside it. What is here is imported when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gpsec.core.version import __version__

if TYPE_CHECKING:
    from gpsec.core.errors import GpsecError, MachineError
    from gpsec.core.progress import Progress
    from gpsec.running.api import check, read_scenario, run
    from gpsec.running.checking import Checked
    from gpsec.running.results import Results, unit
    from gpsec.scenario import Scenario
    from gpsec.sweeps.api import sweep
    from gpsec.sweeps.results import Sweep, load
    from gpsec.training import Driving, TrainingProgress, calibrate, train

__all__ = [
    "Checked",
    "Driving",
    "GpsecError",
    "MachineError",
    "Progress",
    "Results",
    "Scenario",
    "Sweep",
    "TrainingProgress",
    "__version__",
    "calibrate",
    "check",
    "load",
    "read_scenario",
    "run",
    "sweep",
    "train",
    "unit",
]

_HOMES = {
    "gpsec.core.errors": ("GpsecError", "MachineError"),
    "gpsec.core.progress": ("Progress",),
    "gpsec.running.api": ("check", "read_scenario", "run"),
    "gpsec.running.checking": ("Checked",),
    "gpsec.running.results": ("Results", "unit"),
    "gpsec.scenario": ("Scenario",),
    "gpsec.sweeps.api": ("sweep",),
    "gpsec.sweeps.results": ("Sweep", "load"),
    "gpsec.training": ("Driving", "TrainingProgress", "calibrate", "train"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'gpsec' has no attribute '{name}'")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
