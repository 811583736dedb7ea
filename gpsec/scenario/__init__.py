"""A scenario folder, its `gpsec.toml` or a `.sumocfg` becomes one validated, frozen `Scenario`."""

from gpsec.scenario.load import load_scenario
from gpsec.scenario.model import Scenario

__all__ = ["Scenario", "load_scenario"]
