"""The programs and tools that come with SUMO, run as processes."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path


def sumo_home() -> Path:
    """Return the folder of the SUMO that was installed with gpsec."""
    import sumo  # late: nothing else needs it

    return Path(sumo.SUMO_HOME)


def run_program(name: str, arguments: Sequence[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a program of SUMO, such as netconvert, inside `folder`; its exit status is the caller's to judge."""
    suffix = ".exe" if sys.platform == "win32" else ""
    return _run([str(sumo_home() / "bin" / f"{name}{suffix}"), *arguments], folder)


def run_tool(name: str, arguments: Sequence[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a Python tool of SUMO, such as randomTrips.py, inside `folder`; its exit status is the caller's to judge."""
    return _run([sys.executable, str(sumo_home() / "tools" / name), *arguments], folder)


def _run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False
    )
