"""Traffic from libsumo, in-process: starts it, steps it, reads it in one loop over the vehicles."""

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from time import perf_counter
from types import TracebackType
from typing import Self

import libsumo

from gpsec.core.errors import GpsecError, retold
from gpsec.sumo.home import sumo_home
from gpsec.traffic.names import VehicleNames, numbered_ids
from gpsec.traffic.options import SumoOptions
from gpsec.traffic.outputs import without_lost_outputs
from gpsec.traffic.roster import Roster
from gpsec.traffic.source import Equip, Frame, step_count
from gpsec.traffic.stderr import CaughtStderr, sumo_words
from gpsec.traffic.sumo_gui import GuiWindow, Look, WindowClosedError, window_arguments
from gpsec.traffic.vehicle_attacks import Spoofers, carried_attacks, check_departing
from gpsec.traffic.vehicletypes import check_type_keys
from gpsec.traffic.zones import KeysOfTypes, read_zones
from gpsec.types.drawn_zones import DrawnZone

# Neither is a kind of the other.
SUMO_ERRORS = (libsumo.TraCIException, libsumo.FatalTraCIError)

# SUMO puts its output prefix before the last part of a path, whatever folder that is in; this many steps up
# end in the root folder, from where the temporary one is reached.
_TO_ROOT = "../" * 64


class SumoSession:
    """A running simulation; implements `gpsec.traffic.source.TrafficSource`.

    libsumo allows one simulation per process. A vehicle that is equipped stays so for its life: after a teleport,
    a stay in a parking area or a jump it goes on as a new vehicle ``id#2``, without `equip` being asked again.

    Attributes:
        options: what it was started with.
        step_s: length of a step.
        sumo_s: wall-clock seconds spent in SUMO's steps so far.
        read_s: wall-clock seconds spent reading the vehicles so far.
        warnings: SUMO's warnings and errors, once closed; at most 10 of a kind.
    """

    def __init__(
        self, options: SumoOptions, lane_index: Mapping[str, int], equip: Equip, delay_ms: float | None = None
    ) -> None:
        """Start the simulation.

        Args:
            options: from `gpsec.traffic.options.resolve_options`.
            lane_index: index in the HD map of each lane id; a vehicle on another lane is not on the map.
            equip: decides at departure whether a vehicle is part of the fleet.
            delay_ms: shows it in sumo-gui, with so much time for a step once a vehicle is followed; None shows nothing.

        Raises:
            GpsecError: SUMO refuses to start, a ``gpsec.…`` parameter is wrong, or another session is open.
        """
        if libsumo.isLoaded():
            raise GpsecError("a simulation is open in this process already: libsumo allows one, close it first")
        self.options = options
        self.sumo_s = 0.0
        self.read_s = 0.0
        self.warnings: list[str] = []
        self._input_files = (*options.additional_files, *options.route_files)
        check_type_keys(self._input_files)
        check_departing(self._input_files)
        names = VehicleNames(numbered_ids(self._input_files))
        self._roster = Roster(lane_index, equip, Spoofers(carried_attacks(self._input_files)), names)
        self._step = 0
        self._open = True
        self._stderr = CaughtStderr()
        self._folder = Path(tempfile.mkdtemp(prefix="gpsec-sumo-")).resolve()
        self._copies: dict[Path, Path] = {}
        self._window: GuiWindow | None = None
        self._start(["sumo"] if delay_ms is None else ["sumo-gui", *window_arguments(self._folder)])
        if delay_ms is not None:
            self._window = GuiWindow(delay_ms)

    def _start(self, program: list[str]) -> None:
        outputs = {
            "output-prefix": f"{_TO_ROOT}{str(self._folder).lstrip('/')}/",
            "error-log": str(self._folder / "sumo.log"),
        }
        os.environ["SUMO_HOME"] = str(sumo_home())  # where libsumo looks for what comes with it
        try:
            self._copies = without_lost_outputs([self.options.net_file, *self._input_files], self._folder)
            arguments = [*program, *(self._with_copies(value) for value in self.options.arguments)]
            for name, value in outputs.items():
                arguments += [f"--{name}", value]
            with self._stderr:
                libsumo.start(arguments)
            self.step_s: float = libsumo.simulation.getDeltaT()
            self._begin_s: float = libsumo.simulation.getTime()
        except SUMO_ERRORS as error:
            raise self._sumo_error(error) from None
        except BaseException:
            self.close()
            raise

    def _with_copies(self, value: str) -> str:
        """Return the value of an option with the copies of files in place of those that SUMO cannot run."""
        if not self._copies:
            return value
        return ",".join(str(self._copies.get(Path(name).resolve(), name)) for name in value.split(","))

    def _in_words_of_the_user(self, words: str) -> str:
        """Return what SUMO says with the user's paths in place of ours."""
        words = words.replace(f"{_TO_ROOT}{str(self._folder).lstrip('/')}/", "")
        for path, copy in self._copies.items():
            words = words.replace(str(copy), str(path))
        return words

    def _sumo_error(self, error: Exception) -> GpsecError | WindowClosedError:
        if self._window is not None and not libsumo.isLoaded():
            self.close()
            return WindowClosedError()
        words = self._in_words_of_the_user(sumo_words(self._stderr.text(), str(error)))
        self.close()
        return GpsecError(f"{self.options.config}: SUMO says: {retold(words)}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def traffic_only(self) -> dict[str, int]:
        """Vehicles so far of each SUMO class that is never equipped; those that carry a spoofer are not among them."""
        return dict(self._roster.traffic_only)

    def zones(self, known_keys: KeysOfTypes) -> list[DrawnZone]:
        """Return the zones that are drawn in the scenario; see `gpsec.traffic.zones.read_zones`."""
        return read_zones(known_keys, self._input_files)

    def frames(self, duration_s: float | None = None) -> Iterator[Frame]:
        """Yield the steps until no vehicle is left or to come, the scenario ends, or `duration_s` is over.

        Where nobody has departed by then (a day's traffic that begins late), `duration_s` counts from the first one.

        Raises:
            GpsecError: SUMO gives up, in its words.
            WindowClosedError: the user has closed the window.
        """
        asked = None if duration_s is None else step_count(self._step * self.step_s + duration_s, self.step_s)
        end_s = self.options.end_s
        end = None if end_s is None else step_count(end_s - self._begin_s, self.step_s)
        anybody = False
        while self._goes_on() and (end is None or self._step < end):
            if asked is not None and self._step >= asked and (anybody or duration_s == 0.0):
                return
            frame = self._next_frame()
            if not anybody and frame.on_road > 0:
                anybody = True
                if duration_s is not None and asked is not None and frame.step >= asked:
                    asked = frame.step + step_count(duration_s, self.step_s)
            yield frame

    def show(self, look: Look) -> None:
        """Show in the window what the evaluation says of the last step.

        Raises:
            WindowClosedError: the user has closed it.
        """
        if self._window is None:
            return
        try:
            self._window.show(look)
        except SUMO_ERRORS as error:
            raise self._sumo_error(error) from None

    def _goes_on(self) -> bool:
        try:
            return bool(libsumo.simulation.getMinExpectedNumber() > 0)
        except SUMO_ERRORS as error:
            raise self._sumo_error(error) from None

    def _next_frame(self) -> Frame:
        before = perf_counter()
        try:
            with self._stderr:
                libsumo.simulation.step()
            stepped = perf_counter()
            self._roster.read(self.step_s)
        except SUMO_ERRORS as error:
            raise self._sumo_error(error) from None
        rows, front_m, lane = self._roster.positions()
        frame = Frame(
            step=self._step,
            time_s=libsumo.simulation.getTime(),
            left=self._roster.left,
            departures=self._roster.departures,
            rows=rows,
            front_m=front_m,
            lane=lane,
            on_road=libsumo.vehicle.getIDCount(),
            spoofers_m=self._roster.spoofers.positions(),
        )
        self._step += 1
        self.sumo_s += stepped - before
        self.read_s += perf_counter() - stepped
        return frame

    def close(self) -> None:
        """End the simulation and delete what it wrote."""
        if not self._open:
            return
        self._open = False
        try:
            # With a window, libsumo would wait for its events for ever; its process ends without that.
            if libsumo.isLoaded() and self._window is None:
                with self._stderr:
                    libsumo.close()
        finally:
            log = self._folder / "sumo.log"
            said = log.read_text(errors="replace") if log.exists() else ""
            self.warnings = self._in_words_of_the_user(said).splitlines()
            shutil.rmtree(self._folder, ignore_errors=True)
            self._stderr.close()
