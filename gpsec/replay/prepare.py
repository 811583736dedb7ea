"""Makes a scenario of a log, so that it can be run, resumed and looked at again like any other."""

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from xml.sax.saxutils import quoteattr

from gpsec.core import caches
from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence, refusal
from gpsec.replay.chain import LaneChain, make_chain, write_chain
from gpsec.replay.fcd import FcdClock, read_clock
from gpsec.replay.grid import LOG_STEP_S, SteppedDrive, on_steps
from gpsec.replay.log import DriveLog
from gpsec.replay.logged import AXLE_M
from gpsec.replay.readers import FCD, choose_reader, content_digest, read_drive
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.outside import NOTHING, Outside
from gpsec.scenario.overrides import Override

_CONFIG, _NET, _DIGEST, _ORDER = "log.sumocfg", "chain.net.xml", "log.add.xml", "replay.json"
# A change of what is written here makes new entries in the cache.
_FORMAT = 1
# An attack of the defaults is over before the log is.
_ATTACK_S = 30.0


@dataclass(frozen=True)
class LogOrder:
    """What is replayed.

    Attributes:
        log: absolute path.
        reader: name of its reader.
        net: absolute path of a net, empty where the log's own chain is taken.
        copies: how often a drive takes part.
        digest: of the log.
    """

    log: str
    reader: str
    net: str
    copies: int
    digest: str


@dataclass(frozen=True)
class Laid:
    """A drive on its chain.

    Attributes:
        log: as it was read.
        drive: on steps.
        chain: that it lies on.
    """

    log: DriveLog
    drive: SteppedDrive
    chain: LaneChain


def lay(log: DriveLog) -> Laid:
    """Return a drive on steps, and the chain that it lies on; where the camera saw another lane, it saw none."""
    drive = on_steps(log)
    chain = make_chain(drive, AXLE_M)
    if len(drive.lane):
        drive = replace(drive, lane_there=drive.lane_there & ~chain.blind)
    return Laid(log, drive, chain)


def place_order(log: Path, reader: str | None, net: Path | None, copies: int) -> LogOrder:
    """Return the order for a log.

    Raises:
        GpsecError: there is no such log, reader or net, or the reader needs a net, or none.
    """
    name = choose_reader(log, reader)
    if name == FCD and net is None:
        raise GpsecError(f"{log}: expected --net with the net that this traffic drove on")
    if name != FCD and net is not None:
        raise GpsecError(
            f"--net {net}: expected it for SUMO's FCD output only; a drive lies on the chain of its own pose"
        )
    if net is not None and not net.is_file():
        raise GpsecError(f"--net {net}: no such net file")
    return LogOrder(str(log.resolve()), name, str(net.resolve()) if net else "", copies, content_digest(log))


def prepare(order: LogOrder) -> Path:
    """Return the SUMO configuration of a log, which stands for it in a scenario; it is kept in the cache.

    Raises:
        GpsecError: no run can be made of the log, or the cache cannot be written.
    """
    told = json.dumps({"format": _FORMAT, **asdict(order)}, sort_keys=True)
    folder = caches.cache_folder() / "logs" / hashlib.sha256(told.encode()).hexdigest()[:32]
    if not caches.is_whole(folder):
        laid = None if order.reader == FCD else lay(read_drive(Path(order.log), order.reader))
        try:
            with caches.new_folder(folder) as part:
                _fill(part, order, laid, told)
        except OSError as error:
            if not caches.is_whole(folder):  # another process was not first
                raise refusal(error, f"{folder}: the log cannot be kept there") from None
    return folder / _CONFIG


def _fill(folder: Path, order: LogOrder, laid: Laid | None, told: str) -> None:
    net = order.net
    if laid is not None:
        write_chain(laid.chain, laid.log.projection, folder / _NET)
        net = _NET
    clock = (
        read_clock(Path(order.log)) if laid is None else FcdClock(LOG_STEP_S, LOG_STEP_S, len(laid.drive) * LOG_STEP_S)
    )
    begin_s = max(clock.first_s - clock.step_s, 0.0)
    ends = "" if clock.last_s is None else f'<end value="{clock.last_s:.6f}"/>'
    (folder / _ORDER).write_text(told + "\n", encoding="utf-8")
    # A run depends on the files that its configuration names: this one stands for the log's content.
    (folder / _DIGEST).write_text(f"<additional><!-- log {order.digest} --></additional>\n", encoding="utf-8")
    (folder / _CONFIG).write_text(
        "<configuration><input>"
        f"<net-file value={quoteattr(net)}/><additional-files value={quoteattr(_DIGEST)}/></input>"
        f'<time><begin value="{begin_s:g}"/>{ends}<step-length value="{clock.step_s:g}"/></time></configuration>\n',
        encoding="utf-8",
    )


def order_of(scenario: Scenario) -> LogOrder | None:
    """Return the order that a scenario stands for, None where it is no log's.

    Raises:
        GpsecError: the log has changed since.
    """
    path = scenario.sumocfg.with_name(_ORDER)
    if scenario.sumocfg.name != _CONFIG or not path.is_file():
        return None
    with in_a_sentence(f"{path}: cannot be read"):
        told = json.loads(path.read_text("utf-8"))
    order = LogOrder(**{name: told[name] for name in LogOrder.__dataclass_fields__})
    if content_digest(Path(order.log)) != order.digest:
        raise GpsecError(f"{order.log}: the log has changed since this run was prepared; replay it again")
    return order


def replay_scenario_of(
    order: LogOrder, config: Path | None, changes: Sequence[Override], outside: Outside = NOTHING
) -> Scenario:
    """Return the scenario of a log.

    Args:
        order: for the log.
        config: a gpsec.toml whose keys are taken, all but its traffic.
        changes: of the command line.
        outside: parts from outside gpsec.

    Raises:
        GpsecError: no run can be made of the log, a key or value is wrong, or there is a closed loop.
    """
    sumocfg = prepare(order)
    first = [
        Override(("sumocfg",), str(sumocfg), f"{order.log}"),
        Override(("name",), log_name(Path(order.log)), f"{order.log}"),
    ]
    # SUMO's sublanes have no meaning here.
    first.append(Override(("traffic", "lateral_resolution_m"), 0.0, f"{order.log}"))
    if order.reader != FCD and config is None:
        first.append(Override(("plans",), _plans(sumocfg), f"{order.log}"))
    scenario = load_scenario(sumocfg if config is None else config, [*first, *changes], outside)
    if "closed_loop" in scenario.model_fields_set:
        raise GpsecError(
            f"{config or order.log}: closed_loop: expected no such section for a replay, found one: recorded traffic"
            " cannot react"
        )
    return scenario


def log_name(log: Path) -> str:
    """Return the name of a log for tables and folders."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", log.name.split(".")[0] or log.name).strip("._-")
    return plain or "log"


def _plans(sumocfg: Path) -> list[dict[str, object]]:
    """Return the default plans: every attack on every copy, at any time of the log."""
    from gpsec.scenario.choices import fixed_attacks

    found = re.search(r'<end value="([^"]*)"', sumocfg.read_text("utf-8"))
    lasts_s = float(found[1]) if found else 0.0
    latest_s = max(lasts_s - 10.0 - _ATTACK_S, 0.0)
    return [{"attack": name, "share": 1.0, "start_after_s": [0.0, latest_s]} for name in fixed_attacks()]
