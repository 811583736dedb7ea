"""Which SUMO is used: one for programs, tools, scenarios that come with it, and the data of the simulation."""

import os
import re
import subprocess
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path

_VARIABLE = re.compile(r"\$\{(.+?)\}")
# SUMO knows these by itself where the environment does not.
_SET_BY_SUMO = ("LOCALTIME", "UTC", "PID", "SUMO_LOGO")
_SUFFIX = ".exe" if sys.platform == "win32" else ""


def sumo_home() -> Path:
    """Return the folder of the one SUMO that all of gpsec uses.

    It is the one that SUMO_HOME names where that is of the version of libsumo, otherwise the one that is installed with
    gpsec, so that programs, scenarios and the simulation are never of two SUMOs.
    """
    import sumo  # late: nothing else needs it

    named = os.environ.get("SUMO_HOME", "")
    installed = Path(sumo.SUMO_HOME)
    return Path(named) if named and (Path(named) == installed or _is_tested(named)) else installed


def program(name: str) -> Path:
    """Return the path of a program of SUMO, such as netconvert."""
    return sumo_home() / "bin" / f"{name}{_SUFFIX}"


def environment() -> dict[str, str]:
    """Return the environment that a program of SUMO runs in: it looks for its schemas and types in SUMO_HOME."""
    return {**os.environ, "SUMO_HOME": str(sumo_home())}


def expand_variables(text: str) -> str:
    """Return `text` with what each ``${NAME}`` in it stands for, as SUMO reads options: nothing for an unknown one."""
    known = environment() if "${" in text else {}
    return _VARIABLE.sub(lambda found: known.get(found[1], found[0] if found[1] in _SET_BY_SUMO else ""), text)


@cache
def _is_tested(home: str) -> bool:
    """Return whether there is a SUMO in a folder that is of the version of libsumo."""
    command = [str(Path(home) / "bin" / f"sumo{_SUFFIX}"), "--version"]
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False
        )
    except (OSError, ValueError):
        return False
    expected = ".".join(version("libsumo").split(".")[:2])
    return f" {expected}." in done.stdout.partition("\n")[0]
