"""SUMO in a process of its own: the next step is simulated while this one is evaluated.

libsumo holds the interpreter lock through a step, so a thread would not help; a process also keeps libsumo's one
simulation out of the evaluator. What every vehicle has in every step goes through a ring of shared memory, the rest
(who departs, who leaves) through a pipe. When either side dies, the other one sees the pipe close and ends.

Where the run is shown in sumo-gui, SUMO waits after every step for what the evaluation says of it. Where vehicles are
steered, it is one step ahead, and takes commands.
"""

import os
from collections.abc import Iterator, Mapping
from functools import cached_property
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.pipes import PeerGoneError, receive, send
from gpsec.core.processes import SPAWN, ended_early
from gpsec.traffic.commands import Carried, Commands
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.ring import CAPACITY, DEPTH, Head, Ring
from gpsec.traffic.serving import Pace, serve
from gpsec.traffic.source import Equip, Frame
from gpsec.traffic.zones import KeysOfTypes
from gpsec.types.drawn_zones import DrawnZone

if TYPE_CHECKING:
    from gpsec.traffic.sumo_gui import Look


class RemoteSession:
    """`SumoSession` in another process; implements `gpsec.traffic.source.TrafficSource`.

    Attributes:
        options: what it was started with.
        sumo_s, read_s: wall-clock seconds that the other process has spent in SUMO and in reading it.
        warnings: SUMO's, once the frames are over.
        traffic_only: vehicles of each SUMO class that is never equipped, then too.
        look: what is to be seen of the step that was yielded last; None where there is no window.
        carried: how commands were carried out in that step, None where it takes none.
    """

    def __init__(
        self,
        options: SumoOptions,
        lane_index: Mapping[str, int],
        equip: Equip,
        capacity: int = CAPACITY,
        delay_ms: float | None = None,
        controlled: bool = False,
    ) -> None:
        """Start the simulation; see `SumoSession`, and `ControlledSession` where it is `controlled`.

        `equip` goes to another process: a function of a module, or a method of a plain object. `capacity` is the number
        of vehicles for which there is shared memory; steps with more take the slower way. `delay_ms` shows the run in
        sumo-gui, with so much time for a step. What SUMO refuses is said when it is first asked for something.
        """
        blocks = SPAWN.RawArray("i", DEPTH * 2 * capacity), SPAWN.RawArray("d", DEPTH * capacity * 2)
        self.options = options
        self.sumo_s = 0.0
        self.read_s = 0.0
        self.warnings: list[str] = []
        self.traffic_only: dict[str, int] = {}
        self.look: Look | None = None
        self.carried: Carried | None = None
        self._shown, self._controlled = delay_ms is not None, controlled
        self._commands = Commands.none()
        self._ring = Ring(*blocks)
        self._connection, theirs = SPAWN.Pipe()
        arguments = (theirs, blocks, options, dict(lane_index), equip, Pace(delay_ms, controlled))
        self._process = SPAWN.Process(target=serve, args=arguments, name="sumo", daemon=True)
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

    def zones(self, known_keys: KeysOfTypes) -> list[DrawnZone]:
        """Return the zones that are drawn in the scenario; to be called before the first step."""
        _ = self.step_s  # the first answer
        self._send({kind: list(keys) for kind, keys in known_keys.items()})
        found: list[DrawnZone] = self._receive()
        return found

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        """Yield the steps, as `SumoSession.frames` does; it can be called once.

        Raises:
            GpsecError: SUMO gives up, in its words.
            MachineError: its process is gone.
            KeyboardInterrupt: the user has closed the window.
        """
        _ = self.step_s  # the first answer
        self._send(duration_s)
        while isinstance(head := self._receive(), Head):
            self.sumo_s, self.read_s = head.sumo_s, head.read_s
            frame = head.frame if head.in_ring is None else self._ring.take(head.frame, head.in_ring)
            if not (self._shown or self._controlled):
                self._send(None)  # its place in the ring is free
            self.carried = frame.carried
            yield frame
            if self._shown or self._controlled:
                self._send(self._answer())
                self._commands = Commands.none()
        self.warnings, self.traffic_only = head

    def _answer(self) -> object:
        """Return what SUMO waits for after a step."""
        if not self._controlled:
            return self.look
        return (self.look, self._commands) if self._shown else self._commands

    def command(self, commands: Commands) -> None:
        """Say what is to be done after the step that was yielded last: it acts in the step after the next."""
        self._commands = commands

    def _send(self, message: object) -> None:
        try:
            send(self._connection, message)
        except PeerGoneError:
            return  # what SUMO's process said before it ended lies in the pipe, and is read next

    def _receive(self) -> Any:
        try:
            answer = receive(self._connection)
        except PeerGoneError:
            raise self._gone() from None
        if isinstance(answer, GpsecError | KeyboardInterrupt):
            self.close()
            raise answer
        return answer

    def _gone(self) -> GpsecError:
        """Return what to say of a process that ended without a word."""
        self._process.join(5.0)
        if self._shown and "step_s" not in vars(self):  # where there is no display, SUMO exits without a word
            return GpsecError(
                f"{self.options.config}: sumo-gui could not open its window on the display"
                f" '{os.environ.get('DISPLAY', '')}'; expected one that is there and has OpenGL"
            )
        how = ended_early("the process of SUMO", self.exit_code, "a crash of SUMO itself")
        return MachineError(f"{self.options.config}: {how}")

    def close(self) -> None:
        """End the simulation and its process; steps that were simulated ahead are dropped."""
        self._connection.close()
        self._process.join(10.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
