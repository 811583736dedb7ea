"""Imports OpenDRIVE with netconvert, and takes out of the result what changes from run to run."""

from __future__ import annotations

import re
from pathlib import Path

from gpsec.opendrive.netconvert import OPENDRIVE_OPTIONS
from gpsec.opendrive.tidy import give_extent, thin_out
from gpsec.sumo.tools import run_program
from sumo_nets.plan import Plan


def netconvert(plan: Plan, source: Path, target: Path) -> list[str]:
    """Import `source` into `target`; return netconvert's warnings. Raises RuntimeError with its words if it fails."""
    arguments = [
        f"--opendrive-files={source}",
        f"--output-file={target}",
        f"--opendrive.curve-resolution={plan.curve_resolution_m}",
        *OPENDRIVE_OPTIONS,
        *plan.netconvert,
    ]
    run = run_program("netconvert", arguments, Path.cwd())
    if run.returncode != 0:
        raise RuntimeError(f"netconvert cannot import {source.name}: {run.stderr.strip()}")
    text = re.sub(r"<!--.*?-->\s*", "", target.read_text(encoding="utf-8"), flags=re.DOTALL)
    target.write_text(thin_out(give_extent(text)), encoding="utf-8")
    return run.stderr.strip().splitlines()
