"""Coast: dead reckoning by another name, to have a response of one's own."""

from typing import ClassVar

from gpsec.localization.responses import DeadReckoning


class Coast(DeadReckoning):
    """Odometer and gyro only."""

    name: ClassVar[str] = "coast"
