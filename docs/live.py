"""Takes the picture of `gpsec run --gui` for the README, on a display of its own: `python docs/live.py`.

Needs Xvfb, xdotool and ImageMagick's `import` and `convert` (Debian: xvfb xdotool imagemagick), no network.
"""

import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.view import StepView
from gpsec.pipeline.live import CLEAN, Live
from gpsec.pipeline.run import run_scenario
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set
from gpsec.types.vehicles import Identity

DOCS = Path(__file__).parent
PICTURE = DOCS / "pictures" / "live.png"
NEEDED = ("Xvfb", "xdotool", "import", "convert")
PLAN, DEFENCE = "spoofed_quarter", "lstm_glr+ukf"
# A picture is taken when vehicles of so many states, besides the clean ones, are so near to the one that is followed.
STATES, NEAR_M = 3, 40.0
WIDTH, HEIGHT = 1000, 760
# The view alone in a window of that size: no paths, no tool bars.
VIEW = "990x530+5+127"


class Taken(Exception):  # noqa: N818
    """There is a picture."""


class Photographer(Live):
    """Takes a picture of the window when there is enough to see, and ends the run."""

    def see(self, view: StepView, outcomes: OutcomeState, fleet: Mapping[int, Identity]) -> None:
        """Show the step, and look at the window, which has the step before."""
        if self._near >= STATES:
            time.sleep(2.0)  # sumo-gui draws when it has time
            take_picture()
            raise Taken
        if view.step == 5:
            fill_screen()
        super().see(view, outcomes, fleet)
        if self._followed >= 0:
            rows = np.array(list(self._shown))
            way_m = view.vehicles.front_m[rows] - view.vehicles.front_m[self._followed]
            near = rows[np.hypot(way_m[:, 0], way_m[:, 1]) < NEAR_M].tolist()
            self._near = len({self._shown[row][1] for row in near} - {CLEAN})

    _near = 0


def fill_screen() -> None:
    """Let the window take the whole display."""
    found = subprocess.run(["xdotool", "search", "--name", "SUMO"], capture_output=True, text=True, check=True)
    window = found.stdout.split()[-1]
    subprocess.run(
        ["xdotool", "windowmove", window, "0", "0", "windowsize", window, str(WIDTH), str(HEIGHT)], check=True
    )


def take_picture() -> None:
    """Write what the display shows, with few colours so that the file is small."""
    subprocess.run(["import", "-window", "root", "-crop", VIEW, str(PICTURE)], check=True, timeout=60)
    reduce = ["+repage", "-strip", "-colors", "128", "-define", "png:exclude-chunks=date,time", f"PNG8:{PICTURE}"]
    subprocess.run(["convert", str(PICTURE), *reduce], check=True, timeout=60)


def main() -> None:
    """Run the town until vehicles in its zone have many states, and take the picture."""
    if absent := [program for program in NEEDED if shutil.which(program) is None]:
        raise SystemExit(f"not found: {', '.join(absent)} (Debian: apt install xvfb xdotool imagemagick)")
    overrides = [parse_set(change) for change in ("duration_s=200", "outcomes.bootstrap=20")]
    scenario = load_scenario(str(DOCS.parent / "scenarios" / "town"), overrides)
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "+extension", "GLX"]
    with subprocess.Popen(command, pass_fds=(write,), stderr=subprocess.DEVNULL) as screen, os.fdopen(read) as number:
        os.close(write)
        try:
            os.environ.update(DISPLAY=f":{number.readline().strip()}", LIBGL_ALWAYS_SOFTWARE="1")
            live = Photographer(PLAN, DEFENCE, 0.0)
            with tempfile.TemporaryDirectory() as work:
                os.environ["HOME"] = work  # sumo-gui keeps its window's size there
                run_scenario(scenario, Path(work), lambda progress: None, live.start, onlooker=live)
            raise SystemExit(f"never {STATES} states within {NEAR_M:g} m")
        except Taken:
            print(PICTURE)
        finally:
            screen.kill()


if __name__ == "__main__":
    main()
