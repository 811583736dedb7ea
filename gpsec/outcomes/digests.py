"""SHA-256 of the tables of a run: the manifest keeps them, so that one sees later whether they are what was written."""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gpsec.outcomes.tables import (
    EFFECTS,
    LOG_ERRORS,
    LOG_TAPE,
    MAP,
    POOLED_PREFIX,
    STEP_LOG,
    TABLES,
    TRACES,
    WORLD_TABLES,
)

WHOLE, CHANGED, MISSING, ADDED = "whole", "changed", "missing", "added"
# Key of a manifest.
DIGESTS = "tables"


def table_digests(folder: Path, tables: Sequence[str] = TABLES) -> dict[str, str]:
    """Return name -> SHA-256 of the files in `folder` that hold results: `tables`, step logs, traces, maps, tapes.

    What is made of them later (pages, Parquet copies of tables) is not among them.
    """
    return {path.name: _digest(path) for path in _found(folder, tables)}


def compared(folder: Path, stated: Mapping[str, str]) -> dict[str, str]:
    """Return name -> `WHOLE`, `CHANGED`, `MISSING` or `ADDED` of the tables in `folder`, by the digests `stated`."""
    states = {name: _state(folder / name, digest) for name, digest in stated.items()}
    return states | {path.name: ADDED for path in _found(folder, TABLES) if path.name not in stated}


def are_whole(folder: Path, manifest: Mapping[str, Any]) -> bool:
    """Return whether `folder` holds all tables that `manifest` knows the digests of, as they were written."""
    stated = manifest.get(DIGESTS)
    return isinstance(stated, dict) and bool(stated) and all(_state(folder / n, d) == WHOLE for n, d in stated.items())


def _found(folder: Path, tables: Sequence[str]) -> list[Path]:
    paths = [folder / f"{name}.csv" for name in (*tables, LOG_ERRORS, *WORLD_TABLES, EFFECTS)]
    paths += sorted(folder.glob(f"{POOLED_PREFIX}*.csv"))
    for kind in (Path(STEP_LOG), Path(TRACES), Path(MAP), Path(LOG_TAPE)):
        paths += [folder / kind, *sorted(folder.glob(f"{kind.stem}-*{kind.suffix}"))]
    return [path for path in paths if path.is_file()]


def _state(path: Path, digest: object) -> str:
    try:
        return WHOLE if _digest(path) == digest else CHANGED
    except FileNotFoundError:
        return MISSING
    except (OSError, ValueError):
        return CHANGED  # a folder, or nothing that may be read


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
