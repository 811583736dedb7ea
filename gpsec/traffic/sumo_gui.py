"""sumo-gui in libsumo's process: what is shown of a step besides the traffic itself."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import libsumo

# Red, green, blue, opacity.
Colour = tuple[int, int, int, int]
Outline = tuple[tuple[float, float], ...]

# Vehicles that are no part of the fleet, or not seen yet.
GREY: Colour = (150, 150, 150, 255)

_VIEW = "View #0"
_GHOST, _BODY = "gpsec.ghost", "gpsec.body."
# Opacity of a vehicle that is elsewhere.
_FADED = 50
_ABOVE_ALL = 200
# The one that sumo-gui has of itself shows little more than its tool bars.
_WINDOW_SIZE = "1200,800"
# What is seen around a vehicle that is followed.
_AROUND_M = 40.0
# A scheme of sumo-gui that draws vehicles with their shape; on light ground, so that zones are seen.
_SETTINGS = """<viewsettings>
    <scheme name="real world"><background backgroundColor="240,240,235"/></scheme>
    <delay value="0"/>
</viewsettings>
"""


@dataclass(frozen=True)
class Look:
    """What the evaluation wants to be seen after a step.

    Attributes:
        colours: (SUMO's vehicle id, colour) of those whose colour changes; all are on the road.
        ghost: corners of a body in the net's frame where a vehicle is believed to be, empty for none.
        ghost_colour: of it.
        followed: SUMO's id of the vehicle that the view follows, empty for none.
        bodies: (SUMO's id, corners, colour) of vehicles that are elsewhere than SUMO has them: where they truly are.
    """

    colours: Sequence[tuple[str, Colour]] = ()
    ghost: Outline = ()
    ghost_colour: Colour = GREY
    followed: str = ""
    bodies: Sequence[tuple[str, Outline, Colour]] = ()


class WindowClosedError(Exception):
    """The user has closed the window of sumo-gui."""


def window_arguments(folder: Path) -> list[str]:
    """Return the options of sumo-gui that run it without a click, as fast as it can; writes settings into `folder`."""
    settings = folder / "view.xml"
    settings.write_text(_SETTINGS, encoding="utf-8")
    return ["--start", "--gui-settings-file", str(settings), "--window-size", _WINDOW_SIZE]


class Pacer:
    """Lets a step take its time. SUMO's own delay is per simulated second, and cannot be changed once it runs."""

    def __init__(
        self, step_s: float, clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep
    ) -> None:
        """Take `step_s` of the `clock` for a step."""
        self._step_s, self._clock, self._sleep = step_s, clock, sleep
        self._due_s: float | None = None

    def wait(self) -> None:
        """Return a step's time after the last return; at once where that has passed, or was the first."""
        now_s = self._clock()
        if self._due_s is not None and self._due_s > now_s:
            self._sleep(self._due_s - now_s)
            now_s = self._due_s
        self._due_s = now_s + self._step_s


class GuiWindow:
    """Draws looks; sumo-gui shows them with the next step."""

    def __init__(self, delay_ms: float) -> None:
        """Let a step take `delay_ms` at least, from the first on that follows a vehicle."""
        self._pacer = Pacer(delay_ms / 1000.0)
        self._begun = False
        self._followed = ""
        self._colours: dict[str, Colour] = {}  # of those that are on the road
        self._elsewhere: set[str] = set()

    def show(self, look: Look) -> None:
        """Colour vehicles, move the ghost and follow."""
        self._colour(look)
        self._move_bodies(look)
        self._move_ghost(look)
        if look.followed != self._followed:
            self._follow(look.followed)
        self._begun |= bool(look.followed)
        if self._begun:
            self._pacer.wait()

    def _colour(self, look: Look) -> None:
        vehicle = libsumo.vehicle
        grey = ((vehicle_id, GREY) for vehicle_id in libsumo.simulation.getDepartedIDList())
        present = set(vehicle.getIDList())
        for vehicle_id, colour in (*grey, *look.colours):
            if vehicle_id in present:  # it may have departed and arrived within a step
                vehicle.setColor(vehicle_id, colour)
                self._colours[vehicle_id] = colour
        self._colours = {name: colour for name, colour in self._colours.items() if name in present}

    def _move_ghost(self, look: Look) -> None:
        there = _GHOST in libsumo.polygon.getIDList()
        if not look.ghost:
            if there:
                libsumo.polygon.remove(_GHOST, _ABOVE_ALL)
        elif there:
            libsumo.polygon.setShape(_GHOST, look.ghost)
        else:
            libsumo.polygon.add(_GHOST, look.ghost, look.ghost_colour, fill=True, layer=_ABOVE_ALL)

    def _move_bodies(self, look: Look) -> None:
        """Draw who is elsewhere than SUMO has them, and fade where it has them."""
        there = {name for name, _, _ in look.bodies} & self._colours.keys()
        for name in self._elsewhere - there:
            libsumo.polygon.remove(_BODY + name, _ABOVE_ALL)
            if name in self._colours:
                libsumo.vehicle.setColor(name, self._colours[name])
        for name, corners, colour in look.bodies:
            if name not in there:
                continue
            if name not in self._elsewhere:
                libsumo.polygon.add(_BODY + name, corners, colour, fill=True, layer=_ABOVE_ALL)
            libsumo.polygon.setShape(_BODY + name, corners)
            libsumo.polygon.setColor(_BODY + name, colour)
            libsumo.vehicle.setColor(name, (*colour[:3], _FADED))
        self._elsewhere = there

    def _follow(self, vehicle_id: str) -> None:
        if _VIEW not in libsumo.gui.getIDList():
            return  # the user has closed it, or it is still being opened
        if vehicle_id and not self._followed:
            x_m, y_m = libsumo.vehicle.getPosition(vehicle_id)
            libsumo.gui.setBoundary(_VIEW, x_m - _AROUND_M, y_m - _AROUND_M, x_m + _AROUND_M, y_m + _AROUND_M)
        libsumo.gui.trackVehicle(_VIEW, vehicle_id)
        self._followed = vehicle_id
