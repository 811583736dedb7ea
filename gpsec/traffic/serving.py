"""The process of SUMO: answers what the evaluator asks through a pipe, and sends it step after step."""

import os
import sys
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

from gpsec.core.errors import GpsecError
from gpsec.core.pipes import PeerGoneError, receive, send
from gpsec.core.processes import collect_garbage_rarely
from gpsec.core.system import refusal
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.ring import DEPTH, Head, Ring
from gpsec.traffic.source import Equip, Frame

if TYPE_CHECKING:
    from gpsec.traffic.session import SumoSession


@dataclass(frozen=True)
class Pace:
    """What SUMO waits for between steps; by default for nothing.

    Attributes:
        delay_ms: the run is shown in sumo-gui, with so much time for a step, and SUMO waits for what is to be seen.
        controlled: SUMO takes commands: those of a step act in the one after the next, which it waits with for them.
    """

    delay_ms: float | None = None
    controlled: bool = False


def serve(
    connection: Connection,
    blocks: tuple[Any, Any],
    options: SumoOptions,
    lanes: dict[str, int],
    equip: Equip,
    pace: Pace,
) -> None:
    """Be the process of SUMO, until the run is over or the other side is gone."""
    collect_garbage_rarely()
    if pace.delay_ms is None:
        _answer(connection, blocks, options, lanes, equip, pace)
        return
    status = 0
    try:
        _answer(connection, blocks, options, lanes, equip, pace)
    except Exception:
        traceback.print_exc()
        status = 1
    sys.stderr.flush()
    os._exit(status)  # the threads of the window would keep the process for ever


def _answer(
    connection: Connection,
    blocks: tuple[Any, Any],
    options: SumoOptions,
    lanes: dict[str, int],
    equip: Equip,
    pace: Pace,
) -> None:
    try:
        send(connection, _last_word(connection, blocks, options, lanes, equip, pace))
        while True:  # the other side may be some steps behind, and would find a closed pipe instead of them
            receive(connection)
    except PeerGoneError:
        return


def _last_word(
    connection: Connection,
    blocks: tuple[Any, Any],
    options: SumoOptions,
    lanes: dict[str, int],
    equip: Equip,
    pace: Pace,
) -> object:
    """Simulate; return what is to be said when it is over: an error, or warnings and vehicles that are traffic only.

    Raises:
        PeerGoneError: nobody is there to hear it.
    """
    from gpsec.traffic.sumo_gui import WindowClosedError

    try:
        with _session(options, lanes, equip, pace) as session:
            send(connection, session.step_s)
            while isinstance(asked := receive(connection), dict):
                send(connection, session.zones(asked))
            send_all = _send_frames if pace.delay_ms is None else _show_frames
            if pace.controlled:
                send_all = _steer_frames if pace.delay_ms is None else _show_steered_frames
            send_all(connection, Ring(*blocks), session, asked)
    except GpsecError as error:
        return error
    except OSError as error:
        return refusal(error, f"{options.config}: SUMO cannot go on")
    except WindowClosedError:
        return KeyboardInterrupt()
    return session.warnings, session.traffic_only


def _session(options: SumoOptions, lanes: dict[str, int], equip: Equip, pace: Pace) -> "SumoSession":
    # Late: libsumo is for this process alone.
    from gpsec.traffic.controlled import ControlledSession
    from gpsec.traffic.session import SumoSession

    if pace.controlled:
        return ControlledSession(options, lanes, equip, pace.delay_ms)
    return SumoSession(options, lanes, equip, pace.delay_ms)


def _send_frames(connection: Connection, ring: Ring, session: "SumoSession", duration_s: float | None) -> None:
    ahead = 0
    for frame in session.frames(duration_s):
        while ahead == DEPTH or (ahead and connection.poll()):
            receive(connection)
            ahead -= 1
        _send_frame(connection, ring, session, frame)
        ahead += 1


def _show_frames(connection: Connection, ring: Ring, session: "SumoSession", duration_s: float | None) -> None:
    """Send a step, and go on when what is to be seen of it has come."""
    for frame in session.frames(duration_s):
        _send_frame(connection, ring, session, frame)
        if (look := receive(connection)) is not None:
            session.show(look)


def _steer_frames(connection: Connection, ring: Ring, session: Any, duration_s: float | None) -> None:
    """Send a step, and go on with the commands for the one before: the next is simulated while this is evaluated."""
    behind = False
    for frame in session.frames(duration_s):
        _send_frame(connection, ring, session, frame)
        if behind:
            session.command(receive(connection))
        behind = True


def _show_steered_frames(connection: Connection, ring: Ring, session: Any, duration_s: float | None) -> None:
    """Send a step, and wait for what is to be seen of it and for commands, which act as late as without a window."""
    commands = None
    for frame in session.frames(duration_s):
        _send_frame(connection, ring, session, frame)
        look, following = receive(connection)
        if look is not None:
            session.show(look)
        if commands is not None:
            session.command(commands)
        commands = following


def _send_frame(connection: Connection, ring: Ring, session: "SumoSession", frame: Frame) -> None:
    fits = len(frame.rows) <= ring.capacity
    sent, in_ring = (ring.put(frame), len(frame.rows)) if fits else (frame, None)
    send(connection, Head(sent, in_ring, session.sumo_s, session.read_s))
