"""Which files a scenario reads, and which ones its files name: also what they include, however deep."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from xml.parsers import expat

from gpsec.traffic.inputs import UNREADABLE, first_match, is_plain, open_input

# Attributes of SUMO's elements that name a file. `imgFile` and `osgFile` are pictures.
ATTRIBUTES = ("href", "file", "output", "dest", "edgesFile", "imgFile", "osgFile")
# A parameter names a file where its key is one of these or ends in one behind a dot, such as ``device.ssm.file``.
KEYS = ("file", "output")
# Elements whose ``file`` is read; that of all others is written.
_READ_FROM = ("rerouter", "variableSpeedSign", "calibrator")
_ALWAYS_READ = ("href", "edgesFile")

# A file without any of these names none; what is written as a number may be a letter of a name, and a document type may
# define words of its own.
_NAMING = rf"""(\s(?:{"|".join(ATTRIBUTES)})\b|["'.](?:{"|".join(KEYS)})["']|&#|<!DOCTYPE)""".encode()


@dataclass(frozen=True)
class FileReference:
    """A file that an input file of SUMO's names.

    Attributes:
        file: that names it.
        element: tag that it is named in.
        attribute: that names it; of a ``param`` its key.
        value: the name, as it is written.
        is_read: SUMO reads it; otherwise it is written, or shown in sumo-gui.
    """

    file: Path
    element: str
    attribute: str
    value: str
    is_read: bool

    @property
    def path(self) -> Path:
        """The file that is meant: relative to the one that names it."""
        return self.file.parent / self.value


def input_files(paths: Iterable[Path]) -> Iterator[Path]:
    """Yield the files at `paths` and all that SUMO reads because of them, each once, in the order of reading.

    Left out is what does not exist or is no file.
    """
    seen: set[Path] = set()
    waiting = list(paths)[::-1]
    while waiting:
        path = waiting.pop()
        try:
            real = path.resolve()
            if real in seen or not path.is_file():
                continue
        except (OSError, ValueError, RuntimeError):
            continue  # a name that no file system takes, or links in a circle
        seen.add(real)
        yield path
        waiting += [found.path for found in reversed(references(path)) if found.is_read]


def references(path: Path) -> tuple[FileReference, ...]:
    """Return the files that the input file `path` names, in order; of a broken file those before its fault."""
    return _looked_at(path)[0]


def fault(path: Path) -> str:
    """Return why the input file `path` could not be searched to its end, empty where it could."""
    return _looked_at(path)[1]


def _looked_at(path: Path) -> tuple[tuple[FileReference, ...], str]:
    try:
        status = path.stat()
    except (OSError, ValueError):
        return (), ""
    return _references(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=256)  # several stages look, and a route file may have hundreds of megabytes
def _references(path: Path, changed_ns: int, size: int) -> tuple[tuple[FileReference, ...], str]:
    found: list[FileReference] = []

    def start(element: str, attributes: dict[str, str]) -> None:
        found.extend(files_named(path, element, attributes))

    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    try:
        # Most files name none, which a search through their bytes tells sooner.
        if is_plain(path) and not first_match(path, _NAMING):
            return (), ""
        with open_input(path) as stream:
            parser.ParseFile(stream)
    except (*UNREADABLE, expat.ExpatError) as error:
        return tuple(found), str(error)
    return tuple(found), ""


def files_named(path: Path, element: str, attributes: dict[str, str]) -> Iterator[FileReference]:
    """Yield the files that one `element` in the input file `path` names."""
    for name in ATTRIBUTES:
        if value := attributes.get(name, "").strip():
            is_read = name in _ALWAYS_READ or (name == "file" and element in _READ_FROM)
            yield FileReference(path, element, name, value, is_read)
    key = attributes.get("key", "")
    value = attributes.get("value", "").strip()
    if element == "param" and value and key.rpartition(".")[2] in KEYS:
        yield FileReference(path, element, key, value, False)
