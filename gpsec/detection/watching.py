"""Detectors whose statistic is the monitor's: they remember nothing of their own."""

from typing import ClassVar

from gpsec.core.tables import Table
from gpsec.detection.bounds import Stateless
from gpsec.detection.families import KernelDetector


class WatchingDetector(KernelDetector):
    """A detector that compares a statistic of the monitor with a threshold; a subclass states `name` and `kernel`."""

    heeds_alarm: ClassVar[bool] = False
    reads_monitor: ClassVar[bool] = True

    def new_state(self, capacity: int) -> Table[Stateless]:
        """Return a table that remembers nothing."""
        return Table(Stateless, capacity)
