"""Where tapes are: those that gpsec comes with by their names, others by their files."""

from pathlib import Path

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.types.tapes import Tape, read_tape

_FOLDER = Path(__file__).parents[1] / "tapes"
SUFFIX = ".npz"


def shipped_tapes() -> dict[str, Path]:
    """Return the tapes that gpsec comes with, by name."""
    return {path.stem: path for path in sorted(_FOLDER.glob(f"*{SUFFIX}"))}


def tape_file(name: str) -> Path:
    """Return the file of a tape: one that gpsec comes with by its name, any other by a path that ends in ``.npz``.

    Raises:
        GpsecError: there is no such tape.
    """
    if name.endswith(SUFFIX):
        return Path(name)
    known = shipped_tapes()
    if name not in known:
        listed = nearest(name, known) if known else "gpsec comes with none"
        raise GpsecError(f"unknown tape '{shown(name)}': {listed}; a file ends in {SUFFIX}")
    return known[name]


def load_tape(name: str) -> tuple[Tape, str]:
    """Return a tape and its digest, by what a scenario says.

    Raises:
        GpsecError: there is no such tape, or it is damaged.
    """
    return read_tape(tape_file(name))
