"""Reads the manifest of a run, which anybody may have edited."""

import json
from pathlib import Path
from typing import Any

from gpsec.core.errors import GpsecError, shown
from gpsec.outcomes.digests import DIGESTS
from gpsec.types.constants import MANIFEST


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """Return the manifest of the run in `folder`, None where there is none.

    Of its form is known that ``scenarios`` is a list of at least one object, each with the name of another
    ``scenario``. That of a folder that `run_scenario` has written is such a list of one.

    Raises:
        GpsecError: it is another file.
    """
    path = folder / MANIFEST
    try:
        manifest = json.loads(path.read_text("utf-8"))
        json.dumps(manifest, ensure_ascii=False).encode()  # no lone surrogates: no page can hold them
        if "scenarios" not in manifest:
            manifest = {"scenarios": [manifest], **{key: manifest[key] for key in (DIGESTS,) if key in manifest}}
        scenarios = manifest["scenarios"]
        names = [stated["scenario"] for stated in scenarios]
        whole = isinstance(scenarios, list) and all(map(_is_name, names)) and 0 < len(set(names)) == len(names)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise GpsecError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, LookupError, TypeError, RecursionError):
        whole = False
    if not whole:
        raise GpsecError(f"{path}: expected the manifest of a run, found other data")
    found: dict[str, Any] = manifest
    return found


def stated_digests(folder: Path, manifest: dict[str, Any]) -> dict[str, str] | None:
    """Return the digests of the tables by name, None where the run is of a version that kept none.

    Raises:
        GpsecError: they are something else.
    """
    stated = manifest.get(DIGESTS)
    if stated is None:
        return None
    if not isinstance(stated, dict) or not all(_is_name(name) and isinstance(d, str) for name, d in stated.items()):
        raise GpsecError(f"{folder / MANIFEST}: tables: expected name -> SHA-256, found {shown(stated)}")
    return stated


def _is_name(value: object) -> bool:
    """Return whether a value can be part of the name of a file in the folder of a run."""
    return (
        isinstance(value, str) and 0 < len(value) <= 255 and not set(value) & set("/\\\0") and value not in (".", "..")
    )
