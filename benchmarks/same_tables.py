"""Compares the tables of two results folders, byte by byte: ``python -m benchmarks.same_tables BEFORE AFTER``.

The golden test holds one scenario. A refactoring is to keep every table of all seven: run them with the code from
before and with the code from after it, and compare.
"""

import sys
from pathlib import Path

# What a run writes that two runs of the same code agree in; a manifest has times.
TABLES = ("*.csv", "*.geojson")


def differences(before: Path, after: Path) -> list[str]:
    """Return a sentence for every table that is in one of the folders only, or differs."""
    found = []
    mine, other = ({path.name for glob in TABLES for path in folder.glob(glob)} for folder in (before, after))
    for name in sorted(mine ^ other):
        found.append(f"{name}: only in {before if name in mine else after}")
    for name in sorted(mine & other):
        lines, others = ((folder / name).read_bytes().splitlines() for folder in (before, after))
        if lines != others:
            first = next(
                (n for n, (a, b) in enumerate(zip(lines, others, strict=False), 1) if a != b),
                min(len(lines), len(others)),
            )
            found.append(f"{name}: differs from line {first}")
    return found if mine | other else [f"{before}: has no tables"]


def main() -> int:
    """Print what differs, and return 1 where anything does."""
    found = differences(Path(sys.argv[1]), Path(sys.argv[2]))
    print("\n".join(found) or "every table is the same")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
