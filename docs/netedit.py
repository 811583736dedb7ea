"""Drives netedit on a display of its own, and takes the pictures of authoring.md: `python docs/netedit.py`.

Needs Xvfb, xdotool and ImageMagick's `import` and `convert` (Debian: xvfb xdotool imagemagick), no network. A test
uses the same driver to hold that what netedit saves still runs.
"""

import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Self
from xml.etree import ElementTree

from gpsec.sumo import home as sumohome

DOCS = Path(__file__).parent
NEEDED = ("Xvfb", "xdotool", "import", "convert")
WIDTH, HEIGHT = 1280, 800
# Where things are in a window of that size, without a scroll bar: middle of the view, free space in it, and buttons.
MIDDLE, ASIDE = (752, 400), (300, 640)
CREATE_TYPE, EDIT_PARAMETERS = (112, 167), (112, 682)


def missing() -> list[str]:
    """Return the programs that are needed and not there."""
    return [program for program in NEEDED if shutil.which(program) is None]


class Netedit:
    """netedit with one scenario; a context manager.

    Attributes:
        config: the ``.netecfg`` that it has opened.
    """

    def __init__(self, config: Path, x_m: float, y_m: float, zoom: float) -> None:
        """Open `config` with the point (x_m, y_m) in the middle; netedit counts `zoom` in percent of the whole net."""
        self.config = config.resolve()
        self._view = f'<viewsettings><viewport zoom="{zoom}" x="{x_m}" y="{y_m}"/></viewsettings>'
        self._home = Path(tempfile.mkdtemp(prefix="netedit-"))
        self._processes: list[subprocess.Popen[bytes]] = []
        self._environment = dict(os.environ, HOME=str(self._home), LIBGL_ALWAYS_SOFTWARE="1")

    def __enter__(self) -> Self:
        try:
            self._start()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _start(self) -> None:
        read, write = os.pipe()
        screen = ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "+extension", "GLX"]
        self._launch(screen, pass_fds=(write,))
        os.close(write)
        with os.fdopen(read) as stream:
            self._environment["DISPLAY"] = f":{stream.readline().strip()}"
        settings = self._home / "view.xml"
        settings.write_text(self._view)
        program = str(sumohome.program("netedit"))
        where = ["--window-size", f"{WIDTH},{HEIGHT}", "--window-pos", "0,0"]
        # From beside the folder, so that messages, and pictures of them, have short paths.
        config = str(self.config.relative_to(self.config.parents[1]))
        self._launch([program, "--netecfg-file", config, "--gui-settings-file", str(settings), *where])
        self._window = self._xdotool("search", "--sync", "--name", "netedit").split()[-1]
        self._xdotool("windowfocus", self._window)
        self._xdotool("mousemove", *(str(at) for at in ASIDE))  # keys go to where the mouse is
        self.rest()

    def _launch(self, command: list[str], pass_fds: tuple[int, ...] = ()) -> None:
        quiet = subprocess.DEVNULL
        started = subprocess.Popen(
            command,
            env=self._environment,
            cwd=self.config.parents[1],
            stdout=quiet,
            stderr=quiet,
            pass_fds=pass_fds,
        )
        self._processes.append(started)

    def _xdotool(self, *arguments: str) -> str:
        done = subprocess.run(
            ["xdotool", *arguments], env=self._environment, capture_output=True, text=True, check=True, timeout=60
        )
        return done.stdout

    def _screen(self) -> bytes:
        return subprocess.run(
            ["import", "-window", "root", "png:-"], env=self._environment, capture_output=True, check=True, timeout=60
        ).stdout

    def rest(self, seconds: float = 60.0) -> None:
        """Wait until the picture has not changed for a while.

        Raises:
            TimeoutError: it goes on changing.
        """
        last, still, end = b"", 0, time.monotonic() + seconds
        while still < 3:
            if time.monotonic() > end:
                raise TimeoutError(f"{self.config}: netedit did not come to rest")
            time.sleep(0.5)
            now = self._screen()
            # A screen on which nothing is drawn yet packs into next to nothing.
            still = still + 1 if now == last and len(now) > 10_000 else 0
            last = now

    def click(self, place: tuple[int, int]) -> None:
        """Click on a place in the window."""
        x, y = (str(at) for at in place)
        self._xdotool("mousemove", x, y)
        time.sleep(0.5)  # netedit wants to see the mouse arrive
        self._xdotool("click", "1")
        self._xdotool("mousemove", *(str(at) for at in ASIDE))
        self.rest()

    def press(self, key: str) -> None:
        """Press a key, such as ``ctrl+shift+a``."""
        self._xdotool("key", key)
        self.rest()

    def picture(self, path: Path) -> None:
        """Write what is to be seen to `path`, with few colours so that the file is small."""
        path.write_bytes(self._screen())
        reduce = ["-strip", "-colors", "64", "-define", "png:exclude-chunks=date,time", f"PNG8:{path}"]
        subprocess.run(["convert", str(path), *reduce], check=True, timeout=60)

    def save_all(self) -> None:
        """Save zones and types, then demand; a zone has to be in the middle.

        netedit saves nothing that has not changed. So the zone is deleted and taken back, and a type is made.
        """
        self.click(MIDDLE)
        self.press("Delete")
        self.press("ctrl+z")
        self.press("ctrl+shift+a")
        self.press("F3")
        self.press("t")
        self.click(CREATE_TYPE)
        self.press("ctrl+shift+d")

    def close(self) -> None:
        """End netedit and its display."""
        for process in reversed(self._processes):
            process.kill()
            process.wait()
        shutil.rmtree(self._home, ignore_errors=True)


def zone_centre(additional: Path) -> tuple[float, float]:
    """Return the mean of the corners of the first polygon in an additional file."""
    shape = ElementTree.parse(additional).getroot().find("poly").get("shape", "")  # type: ignore[union-attr]
    corners = [tuple(map(float, corner.split(","))) for corner in shape.split()][:-1]
    return sum(x for x, _ in corners) / len(corners), sum(y for _, y in corners) / len(corners)


def main() -> None:
    """Make a scenario of the town's net, open it in netedit, and write the pictures beside authoring.md."""
    if programs := missing():
        raise SystemExit(f"not found: {', '.join(programs)} (Debian: apt install xvfb xdotool imagemagick)")
    net = DOCS.parent / "sumo_nets" / "town" / "town.net.xml"
    pictures = DOCS / "pictures"
    pictures.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        subprocess.run(["gpsec", "new", "mytown", "--net", str(net)], cwd=work, check=True)
        folder = Path(work) / "mytown"
        x_m, y_m = zone_centre(folder / "mytown.add.xml")
        with Netedit(folder / "mytown.netecfg", x_m, y_m, 700.0) as netedit:
            netedit.picture(pictures / "netedit-opened.png")
            netedit.click(MIDDLE)
            netedit.picture(pictures / "netedit-zone.png")
            netedit.click(EDIT_PARAMETERS)
            netedit.picture(pictures / "netedit-parameters.png")
        with Netedit(folder / "mytown.netecfg", x_m, y_m, 700.0) as netedit:
            netedit.press("F3")
            netedit.press("t")
            netedit.picture(pictures / "netedit-types.png")


if __name__ == "__main__":
    main()
