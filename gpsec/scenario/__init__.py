"""A scenario folder, its `gpsec.toml` or a `.sumocfg` becomes one validated, frozen `Scenario`."""

from gpsec.scenario.load import load_scenario
from gpsec.scenario.model import ALLOW_CODE, Scenario

__all__ = ["ALLOW_CODE", "Scenario", "load_scenario"]
