"""Looks into SUMO's input files for the few things that libsumo does not tell."""

import gzip
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import BinaryIO, cast
from xml.etree import ElementTree
from xml.sax.saxutils import unescape

from gpsec.types.constants import PREFIX

# What reading raises where an input file is broken: its compression, its encoding or its XML.
UNREADABLE = (OSError, EOFError, zlib.error, ElementTree.ParseError, ValueError, LookupError)
# How the beginning of a file states its encoding.
_ENCODING = re.compile(rb"""\A<\?xml\s[^>]*?encoding\s*=\s*["']([^"']*)["']""")
_PLAIN = ("utf-8", "us-ascii", "ascii", "iso-8859-1", "iso-8859-15", "latin1", "windows-1252")
_CHUNK = 1 << 22
_OVERLAP = 1024


@dataclass(frozen=True)
class OwnParameter:
    """A ``gpsec.…`` parameter in an input file.

    Attributes:
        file: that it is in.
        element: tag of its owner, such as ``poly`` or ``vType``.
        owner_id: id of its owner.
        owner_type: the owner's attribute ``type``, empty where it has none.
        key: of the parameter, with the prefix.
        value: its text.
    """

    file: Path
    element: str
    owner_id: str
    owner_type: str
    key: str
    value: str


def open_input(path: Path) -> BinaryIO:
    """Open one of SUMO's input files, which may be gzipped."""
    with path.open("rb") as stream:
        zipped = stream.read(2) == b"\x1f\x8b"
    return cast("BinaryIO", gzip.open(path)) if zipped else path.open("rb")


def all_matches(path: Path, pattern: bytes) -> Iterator[str]:
    """Yield the first group of each match of `pattern` (shorter than 1024 bytes), some of them twice.

    A search through the bytes: a route file may have hundreds of megabytes.
    """
    compiled = re.compile(pattern)
    tail = b""
    try:
        with open_input(path) as stream:
            while chunk := stream.read(_CHUNK):
                tail += chunk
                for found in compiled.finditer(tail):
                    yield unescape(found[1].decode(errors="replace"))
                tail = tail[-_OVERLAP:]
    except UNREADABLE:
        return  # SUMO will say what is wrong with the file


def first_match(path: Path, pattern: bytes) -> str:
    """Return the first of `all_matches`, or an empty string."""
    return next(all_matches(path, pattern), "")


def is_plain(path: Path) -> bool:
    """Return whether the markup of a file is in ASCII, so that its bytes can be searched for names."""
    with open_input(path) as stream:
        head = stream.read(200).removeprefix(b"\xef\xbb\xbf")
    if not head.lstrip().startswith(b"<") or b"\0" in head:
        return False  # UTF-16 and others that SUMO may know
    stated = _ENCODING.match(head)
    return not stated or stated[1].decode(errors="replace").lower() in _PLAIN


def own_parameters(path: Path) -> tuple[OwnParameter, ...]:
    """Return the ``gpsec.…`` parameters in an additional or route file, and in what it includes, each file once.

    libsumo gives a parameter only to those who know its key, so a misspelt one is seen only here. Of a broken file
    come those that can be read.
    """
    found: list[OwnParameter] = []
    seen: set[Path] = set()

    def look(file: Path) -> None:
        try:
            status, real = file.stat(), file.resolve()
        except (OSError, ValueError, RuntimeError):
            return  # a name that no file system takes, or links in a circle
        if real in seen:
            return
        seen.add(real)
        for part in _own_parts(file, status.st_mtime_ns, status.st_size):
            if isinstance(part, Path):
                look(part)
            else:
                found.append(part)

    look(path)
    return tuple(found)


@lru_cache(maxsize=256)  # several stages look, and a route file may have hundreds of megabytes
def _own_parts(path: Path, changed_ns: int, size: int) -> tuple[OwnParameter | Path, ...]:
    """Return the parameters in a file, and the files that it includes in their places."""
    found: list[OwnParameter | Path] = []
    owners: list[ElementTree.Element] = []
    try:
        if is_plain(path) and not first_match(path, rb"""(key\s*=\s*["'](?:gpsec\.|[^"']*&#)|<include\s)"""):
            return ()
        with open_input(path) as stream:
            for event, element in ElementTree.iterparse(stream, events=("start", "end")):
                if event == "end":
                    owners.pop()
                    element.clear()
                    continue
                key = element.get("key", "")
                if element.tag == "param" and key.startswith(PREFIX) and owners:
                    owner = owners[-1]
                    names = owner.tag, owner.get("id", ""), owner.get("type", "")
                    found.append(OwnParameter(path, *names, key, element.get("value", "")))
                if element.tag == "include":
                    found.append(path.parent / element.get("href", ""))
                owners.append(element)
    except UNREADABLE:
        pass  # SUMO will say what is wrong with the file
    return tuple(found)
