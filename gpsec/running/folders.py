"""Output folders: what a run writes in them, and whether one may be written."""

from fnmatch import fnmatchcase
from pathlib import Path

from gpsec.core.errors import GpsecError, shown
from gpsec.core.system import in_a_sentence
from gpsec.types.constants import MANIFEST, REPORT

_TABLES = (
    *("detection", "localization", "safety", "events", "vehicles", "curves", "error_bands", "places"),
    *("streets", "association"),
    # Of the closed loop, and of a log.
    *("worlds", "collisions", "crashes", "standing", "jams", "effects"),
    # Over all seeds.
    *("pooled_detection", "pooled_localization", "pooled_safety"),
    *("errors", "impact"),
)
_AS_PARQUET = ("events.parquet", "vehicles.parquet", "places.parquet")
_WRITTEN_BY_RUNS = (MANIFEST, REPORT, *(f"{table}.csv" for table in _TABLES), *_AS_PARQUET)
# What each scenario has one of, under a name of its own where a run has several.
_ONE_EACH = (
    *("steps.parquet", "steps-*.parquet", "traces.parquet", "traces-*.parquet", "map.geojson", "map-*.geojson"),
    *("gnss.tape.npz", "gnss.tape-*.npz"),
)
# What other commands made of a run goes with it.
_MADE_OF_RUNS = ("comparison.html", "places.geojson", "trace-*.html", "log.html", "*.spreadsheet.csv")


def written_by_runs(name: str) -> bool:
    """Return whether a file of this name in an output folder is of a run, or was made of it, and goes with it."""
    if name.startswith(".") and name.endswith(".partial"):
        name = name[1 : -len(".partial")]  # not finished, and left behind by a kill
    return name in _WRITTEN_BY_RUNS or any(fnmatchcase(name, pattern) for pattern in (*_ONE_EACH, *_MADE_OF_RUNS))


def check_output(out: Path, overwrite: bool) -> None:
    """Check that a run may be written to `out`.

    Raises:
        GpsecError: it is a file, or it holds something that would be lost.
    """
    with in_a_sentence(f"{shown(out)}: no results can be written there"):
        there, holds_nothing = out.exists(), not out.is_dir() or not any(out.iterdir())
    if out.is_symlink() and not there:
        raise GpsecError(f"{out}: expected an output folder, found a link that leads nowhere")
    if there and not out.is_dir():
        raise GpsecError(f"{out}: expected an output folder, found a file")
    if holds_nothing:
        return
    # A run of an older version that was killed while it took its place has no manifest.
    if not any((out / name).is_file() for name in _WRITTEN_BY_RUNS):
        raise GpsecError(f"{out}: expected an empty or new folder, found files that no run wrote; choose another --out")
    if not overwrite:
        raise GpsecError(f"{out}: holds another run; give --overwrite to replace it, or choose another --out")


def resolved(out: Path) -> Path:
    """Return `out` as an absolute path without links.

    Raises:
        GpsecError: links lead in a circle, or the current folder is gone.
    """
    try:
        return out.resolve()
    except (OSError, RuntimeError) as error:
        said = getattr(error, "strerror", None) or str(error)
        raise GpsecError(f"{out}: no results can be written there: {said}") from None
