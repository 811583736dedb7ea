"""Imports OpenDRIVE with netconvert, and takes out of the result what changes from run to run."""

from __future__ import annotations

import re
import subprocess
import sys
import sysconfig
from pathlib import Path

from sumo_nets.plan import Plan

OPTIONS = (
    "--precision=4",
    "--precision.geo=8",
    "--opendrive.internal-shapes",
    "--no-turnarounds",
    "--offset.disable-normalization",
    "--junctions.limit-turn-speed=3.5",
    "--tls.default-type=actuated",
    "--output.street-names",
)


def netconvert(plan: Plan, source: Path, target: Path) -> list[str]:
    """Import `source` into `target`; return netconvert's warnings. Raises RuntimeError with its words if it fails."""
    command = [
        _executable(),
        f"--opendrive-files={source}",
        f"--output-file={target}",
        f"--opendrive.curve-resolution={plan.curve_resolution_m}",
        *OPTIONS,
        *plan.netconvert,
    ]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        raise RuntimeError(f"netconvert cannot import {source.name}: {run.stderr.strip()}")
    text = target.read_text(encoding="utf-8")
    target.write_text(re.sub(r"<!--.*?-->\s*", "", text, flags=re.DOTALL), encoding="utf-8")
    return run.stderr.strip().splitlines()


def _executable() -> str:
    """The netconvert that was installed beside this Python, or the one on the path."""
    beside = Path(sysconfig.get_path("scripts")) / ("netconvert.exe" if sys.platform == "win32" else "netconvert")
    return str(beside) if beside.exists() else "netconvert"
