"""Runs netconvert on an OpenDRIVE map with the options that an HD map needs."""

from pathlib import Path

from gpsec.sumo.netconvert import Converted, convert
from gpsec.sumo.tools import Limits

OPENDRIVE_OPTIONS = (
    "--precision=4",
    "--precision.geo=8",
    "--opendrive.internal-shapes",
    "--no-turnarounds",
    "--offset.disable-normalization",
    "--junctions.limit-turn-speed=3.5",
    "--tls.default-type=actuated",
    "--output.street-names",
)
# A map that netconvert does not bear with one of these is tried without it.
_DISPENSABLE = (
    "--opendrive.internal-shapes",
    "--tls.default-type=actuated",
    "--junctions.limit-turn-speed=3.5",
    "--output.street-names",
)
CURVE_RESOLUTION_M = 1.0


def convert_map(source: Path, target: Path, map_file: Path, limits: Limits | None = None) -> Converted:
    """Make the net `target` of the OpenDRIVE file `source` in the same folder; see `gpsec.sumo.netconvert.convert`.

    Raises:
        GpsecError: netconvert refuses the map.
        MachineError: it takes more time or memory than the limits allow, or crashes.
    """
    options = [
        f"--opendrive-files={source.name}",
        f"--opendrive.curve-resolution={CURVE_RESOLUTION_M:g}",
        *(option for option in OPENDRIVE_OPTIONS if option not in _DISPENSABLE),
        "--output.original-names",
    ]
    return convert(options, _DISPENSABLE, target, map_file, limits)
