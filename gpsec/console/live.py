"""`gpsec run --gui`: what is asked of the window, and whether there can be one."""

import os
import sys
from collections.abc import Sequence

from gpsec.core.errors import GpsecError
from gpsec.running.workers import Run


def live_run(
    scenarios: Sequence[str], gui: bool, plan: str | None, defence: str | None, delay_ms: float | None
) -> Run | None:
    """Return what runs a scenario in sumo-gui, None where nothing is to be shown.

    Raises:
        GpsecError: there is no display, there are several scenarios, or an option needs --gui.
    """
    asked = {"--gui-plan": plan, "--gui-defence": defence, "--gui-delay": delay_ms}
    if not gui:
        for option, value in asked.items():
            if value is not None:
                raise GpsecError(f"{option} {value}: expected --gui with it")
        return None
    if len(scenarios) > 1:
        raise GpsecError(f"--gui: expected one scenario, found {len(scenarios)}; show them one after the other")
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        raise GpsecError("--gui: expected a display for the window of sumo-gui, found none (DISPLAY is not set)")
    from gpsec.pipeline.live import DELAY_MS, LiveRun  # late: it is next to everything

    return LiveRun(plan, defence, DELAY_MS if delay_ms is None else delay_ms)
