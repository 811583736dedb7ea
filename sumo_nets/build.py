"""Builds the networks: `python -m sumo_nets.build [--check] [NAME ...]`."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from sumo_nets.author import write
from sumo_nets.convert import netconvert
from sumo_nets.lines import write_lines
from sumo_nets.networks import PLANS

ROOT = Path(__file__).parent


def build(name: str, folder: Path) -> list[str]:
    """Write `folder`/<name>.xodr, .net.xml and .paint.csv; return netconvert's warnings."""
    plan = PLANS[name]()
    folder.mkdir(parents=True, exist_ok=True)
    source, target = folder / f"{name}.xodr", folder / f"{name}.net.xml"
    write(plan, source)
    warnings = netconvert(plan, source, target)
    write_lines(plan, source, target)
    return warnings


def differing(name: str) -> list[Path]:
    """Return the files of a network that a rebuild would change."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        build(name, folder)
        kept = [ROOT / name / path.name for path in sorted(folder.iterdir())]
        return [path for path in kept if not path.exists() or path.read_bytes() != (folder / path.name).read_bytes()]


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m sumo_nets.build", description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing; fail if a file is out of date")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one or more of {', '.join(PLANS)} (default: all)")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.names if name not in PLANS]
    if unknown:
        print(f"There is no network {unknown[0]!r}; there are {', '.join(PLANS)}.", file=sys.stderr)
        return 2
    status = 0
    for name in options.names or PLANS:
        if options.check:
            for path in differing(name):
                print(f"sumo_nets/{name}/{path.name} differs from what sumo_nets.build makes.", file=sys.stderr)
                status = 1
            continue
        for line in build(name, ROOT / name):
            print(f"{name}: {line}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
