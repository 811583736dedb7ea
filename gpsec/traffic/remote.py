"""SUMO in a process of its own: the next step is simulated while this one is evaluated.

libsumo holds the interpreter lock through a step, so a thread would not help; a process also keeps libsumo's one
simulation out of the evaluator. What every vehicle has in every step goes through a ring of shared memory, the rest
(who departs, who leaves) through a pipe. When either side dies, the other one sees the pipe close and ends.

Where the run is shown in sumo-gui, SUMO waits after every step for what the evaluation says of it.
"""

import os
import sys
import traceback
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gpsec.arrays import Floats, Ints
from gpsec.errors import GpsecError
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.source import Departure, Equip, Frame
from gpsec.traffic.zones import ZoneShape

if TYPE_CHECKING:
    from gpsec.traffic.session import SumoSession
    from gpsec.traffic.window import Look

# Steps that SUMO may be ahead, and vehicles that a step in the ring may hold; a larger one goes through the pipe.
DEPTH = 16
CAPACITY = 32_768


class Ring:
    """Shared arrays for `DEPTH` steps.

    Attributes:
        capacity: vehicles that a step may hold.
    """

    def __init__(self, whole: Any, real: Any) -> None:
        """Lay the arrays over two blocks of shared memory, of integers and of floats."""
        self._whole: Ints = np.frombuffer(whole, np.int32).reshape(DEPTH, 2, -1)
        self._real: Floats = np.frombuffer(real, np.float64).reshape(DEPTH, -1, 2)
        self.capacity = self._whole.shape[2]

    def put(self, frame: Frame) -> None:
        """Write the arrays of a step."""
        slot, count = frame.step % DEPTH, len(frame.rows)
        self._whole[slot, 0, :count] = frame.rows
        self._whole[slot, 1, :count] = frame.lane
        self._real[slot, :count] = frame.front_m

    def take(self, step: int, count: int) -> tuple[Ints, Floats, Ints]:
        """Return copies of rows, front and lane of a step."""
        whole = self._whole[step % DEPTH, :, :count]
        return whole[0].copy(), self._real[step % DEPTH, :count].copy(), whole[1].copy()


@dataclass(frozen=True)
class Head:
    """What goes through the pipe for a step.

    Attributes:
        step, time_s, left, departures, on_road, spoofers_m: as in `Frame`.
        count: vehicles in the ring.
        sumo_s, read_s: seconds spent so far.
        frame: the whole step where it did not fit the ring.
    """

    step: int
    time_s: float
    left: list[int]
    departures: list[Departure]
    on_road: int
    spoofers_m: Mapping[str, Floats]
    count: int
    sumo_s: float
    read_s: float
    frame: Frame | None


class RemoteSession:
    """`SumoSession` in another process; implements `gpsec.traffic.source.TrafficSource`.

    Attributes:
        options: what it was started with.
        sumo_s, read_s: wall-clock seconds that the other process has spent in SUMO and in reading it.
        warnings: SUMO's, once the frames are over.
        traffic_only: vehicles of each SUMO class that is never equipped, then too.
        look: what is to be seen of the step that was yielded last; None where there is no window.
    """

    def __init__(
        self,
        options: SumoOptions,
        lane_index: Mapping[str, int],
        equip: Equip,
        capacity: int = CAPACITY,
        delay_ms: float | None = None,
    ) -> None:
        """Start the simulation; see `SumoSession`.

        `equip` goes to another process: a function of a module, or a method of a plain object. `capacity` is the number
        of vehicles for which there is shared memory; steps with more take the slower way. `delay_ms` shows the run in
        sumo-gui, with so much time for a step. What SUMO refuses is said when it is first asked for something.
        """
        context = get_context("spawn")
        blocks = context.RawArray("i", DEPTH * 2 * capacity), context.RawArray("d", DEPTH * capacity * 2)
        self.options = options
        self.sumo_s = 0.0
        self.read_s = 0.0
        self.warnings: list[str] = []
        self.traffic_only: dict[str, int] = {}
        self.look: Look | None = None
        self._shown = delay_ms is not None
        self._ring = Ring(*blocks)
        self._connection, theirs = context.Pipe()
        arguments = (theirs, blocks, options, dict(lane_index), equip, delay_ms)
        self._process = context.Process(target=_serve, args=arguments, name="sumo", daemon=True)
        self._process.start()
        theirs.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @cached_property
    def step_s(self) -> float:
        """Length of a step.

        Raises:
            GpsecError: SUMO refuses to start, or a ``gpsec.…`` parameter is wrong.
        """
        return float(self._receive())

    @property
    def process_id(self) -> int:
        """Number of the other process."""
        return self._process.pid or 0

    @property
    def exit_code(self) -> int | None:
        """How the other process ended, None while it runs."""
        return self._process.exitcode

    def zones(self, known_keys: Collection[str]) -> list[ZoneShape]:
        """Return the attack zones of the scenario; to be called before the first step."""
        _ = self.step_s  # the first answer
        self._connection.send(list(known_keys))
        found: list[ZoneShape] = self._receive()
        return found

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        """Yield the steps, as `SumoSession.frames` does; it can be called once.

        Raises:
            GpsecError: SUMO gives up, in its words, or its process is gone.
            KeyboardInterrupt: the user has closed the window.
        """
        _ = self.step_s  # the first answer
        self._connection.send(duration_s)
        while isinstance(head := self._receive(), Head):
            self.sumo_s, self.read_s = head.sumo_s, head.read_s
            frame = head.frame or self._frame(head)
            if not self._shown:
                self._connection.send(None)  # its place in the ring is free
            yield frame
            if self._shown:
                self._connection.send(self.look)
        self.warnings, self.traffic_only = head

    def _frame(self, head: Head) -> Frame:
        rows, front_m, lane = self._ring.take(head.step, head.count)
        return Frame(
            head.step, head.time_s, head.left, head.departures, rows, front_m, lane, head.on_road, head.spoofers_m
        )

    def _receive(self) -> Any:
        try:
            answer = self._connection.recv()
        except (EOFError, OSError):
            self._process.join(5.0)
            code = self._process.exitcode
            if self._shown and "step_s" not in vars(self):  # where there is no display, SUMO exits without a word
                raise GpsecError(
                    f"{self.options.config}: sumo-gui could not open its window on the display"
                    f" '{os.environ.get('DISPLAY', '')}'; expected one that is there and has OpenGL"
                ) from None
            raise GpsecError(f"{self.options.config}: the process of SUMO ended early (exit status {code})") from None
        if isinstance(answer, GpsecError | KeyboardInterrupt):
            self.close()
            raise answer
        return answer

    def close(self) -> None:
        """End the simulation and its process; steps that were simulated ahead are dropped."""
        self._connection.close()
        self._process.join(10.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _serve(
    connection: Connection,
    blocks: tuple[Any, Any],
    options: SumoOptions,
    lanes: dict[str, int],
    equip: Equip,
    delay_ms: float | None,
) -> None:
    """Be the process of SUMO, until the run is over or the other side is gone."""
    if delay_ms is None:
        _answer(connection, blocks, options, lanes, equip, delay_ms)
        return
    status = 0
    try:
        _answer(connection, blocks, options, lanes, equip, delay_ms)
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
    delay_ms: float | None,
) -> None:
    from gpsec.traffic.session import SumoSession  # late: libsumo is for this process alone
    from gpsec.traffic.window import WindowClosedError

    try:
        with SumoSession(options, lanes, equip, delay_ms) as session:
            connection.send(session.step_s)
            while isinstance(asked := connection.recv(), list):
                connection.send(session.zones(asked))
            send = _send_frames if delay_ms is None else _show_frames
            send(connection, Ring(*blocks), session, asked)
        connection.send((session.warnings, session.traffic_only))
        while True:  # the other side may be some steps behind, and would find a closed pipe instead of them
            connection.recv()
    except GpsecError as error:
        connection.send(error)
    except WindowClosedError:
        connection.send(KeyboardInterrupt())
    except (EOFError, OSError):
        return  # nobody is there any more


def _send_frames(connection: Connection, ring: Ring, session: "SumoSession", duration_s: float | None) -> None:
    ahead = 0
    for frame in session.frames(duration_s):
        while ahead == DEPTH or (ahead and connection.poll()):
            connection.recv()
            ahead -= 1
        _send_frame(connection, ring, session, frame)
        ahead += 1


def _show_frames(connection: Connection, ring: Ring, session: "SumoSession", duration_s: float | None) -> None:
    """Send a step, and go on when what is to be seen of it has come."""
    for frame in session.frames(duration_s):
        _send_frame(connection, ring, session, frame)
        if (look := connection.recv()) is not None:
            session.show(look)


def _send_frame(connection: Connection, ring: Ring, session: "SumoSession", frame: Frame) -> None:
    fits = len(frame.rows) <= ring.capacity
    if fits:
        ring.put(frame)
    head = Head(
        frame.step,
        frame.time_s,
        frame.left,
        frame.departures,
        frame.on_road,
        frame.spoofers_m,
        len(frame.rows),
        session.sumo_s,
        session.read_s,
        None if fits else frame,
    )
    connection.send(head)
