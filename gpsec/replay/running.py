"""Runs a log: the pipeline with the log's traffic, bodies and sensors, then the figures and the tape of its errors."""

from collections.abc import Collection
from dataclasses import fields
from functools import partial
from pathlib import Path

from gpsec.core.errors import GpsecError
from gpsec.core.progress import Progress, Report
from gpsec.core.version import __version__
from gpsec.outcomes.tables import LOG_ERRORS, LOG_TAPE, whole, write_frame
from gpsec.pipeline.logged_run import LoggedRun
from gpsec.pipeline.run import run_scenario
from gpsec.replay.errors import fix_errors
from gpsec.replay.figures import error_table
from gpsec.replay.grid import SteppedDrive
from gpsec.replay.log import DriveLog
from gpsec.replay.logged import Driven, LoggedBodies, LoggedSensors, LoggedTraffic
from gpsec.replay.prepare import Laid, LogOrder, lay, order_of
from gpsec.replay.readers import FCD, read_drive
from gpsec.replay.tape import receiver_tape
from gpsec.replay.traffic import fcd_traffic
from gpsec.scenario import Scenario
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.sense import Sensors
from gpsec.types.tapes import write_tape

_CHANNELS = {
    "fixes": "GNSS fixes",
    "speed": "wheel speed",
    "yaw_rate": "yaw rate",
    "heading": "heading",
    "lane": "camera (lanes)",
}


def replay_log(scenario: Scenario, folder: Path, report: Report, only: Collection[str] | None = None) -> None:
    """Run the scenario of a log into `folder`; as `gpsec.running.workers.Run`.

    Raises:
        GpsecError: the log has changed or cannot be read, or the scenario cannot be run.
    """
    order = order_of(scenario)
    if order is None:
        raise GpsecError(f"{scenario.sumocfg}: expected the configuration of a log, found one of SUMO")
    report(Progress(scenario.name, stage="reading the log"))
    if order.reader == FCD:
        run_scenario(scenario, folder, report, fcd_traffic(order), only)
        return
    laid = lay(read_drive(Path(order.log), order.reader))
    driven = Driven(laid.drive, laid.chain.edge, order.copies, scenario.name)
    recorded = LoggedRun(
        partial(LoggedTraffic, driven),
        LoggedBodies(laid.drive),
        partial(_with_drive, laid.drive),
        (*laid.log.notes, *_notes(laid, order)),
    )
    report(Progress(scenario.name, stage="error statistics"))
    _write_errors(laid.log, order, scenario, folder)  # before the manifest, which says that all is there
    run_scenario(scenario, folder, report, only=only, logged=recorded)


def _with_drive(drive: SteppedDrive, sensors: Sensors) -> LoggedSensors:
    given = {one.name: getattr(sensors, one.name) for one in fields(sensors)}
    return LoggedSensors(**given, drive=drive)


def _write_errors(log: DriveLog, order: LogOrder, scenario: Scenario, folder: Path) -> None:
    profile = PROFILES[next(iter(scenario.fleet.profile))]
    with whole(folder / f"{LOG_ERRORS}.csv") as partial_file:
        write_frame(error_table(log, scenario.name, profile), partial_file)
    series = fix_errors(log)
    if series is not None:
        made = {"made_by": f"gpsec {__version__} replay", "reader": order.reader, "log_sha256": order.digest}
        write_tape(receiver_tape(series, "log", made), folder / LOG_TAPE)


def _notes(laid: Laid, order: LogOrder) -> list[str]:
    """Return what is missing in a log and what stands for it, one sentence each."""
    log = laid.log
    missing = [title for name, title in _CHANNELS.items() if getattr(log, name) is None]
    said = []
    if missing:
        said.append(f"not in the log, and taken from the sensor profile on the log's pose: {', '.join(missing)}")
    if log.lane is None:
        said.append(
            "the log has no lanes: the map is one chain of lanes through its own pose, the camera is the profile's"
        )
    else:
        said.append(
            "the map is one chain of lanes where the log's camera saw them, smoothed over 50 m: an error of the camera"
            " that lasts longer is not seen"
        )
    if laid.chain.changes:
        said.append(
            f"the camera went over to another lane {laid.chain.changes} times; it counts as blind for 3 s about each"
        )
    if order.copies > 1:
        said.append(
            f"the drive takes part {order.copies} times, each attacked at another time; what is honest is the same in"
            " all, so that false alarms are those of one drive and their intervals are too narrow"
        )
    said.append("the log has no body: that of a car of 4.6 m × 1.8 m, in a lane of 3.5 m")
    return said
