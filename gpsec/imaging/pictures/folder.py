"""A folder that is whole as soon as it is there."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence


@contextmanager
def filled_folder(folder: Path) -> Iterator[Path]:
    """Give a folder to fill, which takes the name `folder` once the block has succeeded.

    Raises:
        GpsecError: there is something of that name already, or it cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise GpsecError(f"{folder}: expected a folder that is not there yet or empty; choose another --out")
    with in_a_sentence(f"{folder}: no folder can be written there"):
        part = folder.with_name(f".{folder.name}.part")
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
        try:
            yield part
            if folder.exists():
                folder.rmdir()
            part.rename(folder)
        finally:
            shutil.rmtree(part, ignore_errors=True)
