"""Lets SUMO run where it could not write what an input asks for, or would print it: it gets a copy without that."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import BinaryIO
from xml.sax import SAXException, make_parser
from xml.sax.saxutils import XMLGenerator
from xml.sax.xmlreader import AttributesImpl

from gpsec.sumo.home import expand_variables
from gpsec.traffic.input_files import FileReference, files_named, input_files, references
from gpsec.traffic.inputs import UNREADABLE, open_input

# What SUMO takes for no file, and for what it prints, which would reach our terminal; nothing of pictures is written.
_NO_FILES = ("nul", "null", "/dev/null")
_PRINTED = ("stdout", "stderr", "-")
_PICTURES = ("imgFile", "osgFile")
_NOWHERE = "NUL"


def without_lost_outputs(files: Iterable[Path], folder: Path) -> dict[Path, Path]:
    """Copy into `folder` what SUMO cannot run, and return where each of those files, by its real path, is then.

    These are the input files, included ones too, that name an output in a folder that is not there, which SUMO refuses
    although nothing that it writes is kept, those that let it print, and those that include one of them.
    """
    each = [path.resolve() for path in input_files(files)]
    lost = {path for path in each if any(map(_is_lost, references(path)))}
    while more := {path for path in each if path not in lost and not lost.isdisjoint(_read_by(path))}:
        lost |= more
    copies = {
        path: folder / f"{number}-{path.name.removesuffix('.gz')}" for number, path in enumerate(each) if path in lost
    }
    for path, copy in copies.items():
        _write(path, copy, copies)
    return copies


def _is_lost(named: FileReference) -> bool:
    if not _is_output(named):
        return False
    name = expand_variables(named.value)
    if name.lower() in (*_NO_FILES, *_PRINTED):
        return name.lower() in _PRINTED
    try:
        return not (named.file.parent / name).parent.is_dir()
    except OSError:
        return True


def _is_output(named: FileReference) -> bool:
    return not named.is_read and named.attribute not in _PICTURES


def _read_by(path: Path) -> list[Path]:
    return [found.path.resolve() for found in references(path) if found.is_read]


def _write(path: Path, copy: Path, copies: Mapping[Path, Path]) -> None:
    parser = make_parser()
    try:
        with copy.open("wb") as out, open_input(path) as stream:
            parser.setContentHandler(_Rewriter(out, path, copies))
            parser.parse(stream)
    except (SAXException, *UNREADABLE):
        copy.write_bytes(path.read_bytes())  # SUMO will say what is wrong with the file


class _Rewriter(XMLGenerator):
    """Writes what it is told, but for the files that are named: those that are read in full, outputs nowhere."""

    def __init__(self, out: BinaryIO, path: Path, copies: Mapping[Path, Path]) -> None:
        super().__init__(out, "utf-8")
        self._path = path
        self._copies = copies

    def startElement(self, name: str, attrs: AttributesImpl) -> None:  # noqa: N802
        """Write the beginning of an element."""
        changed = dict(attrs.items())
        for found in files_named(self._path, name, changed):
            if found.is_read:
                real = found.path.resolve()
                changed[found.attribute] = str(self._copies.get(real, real))
            elif _is_output(found):
                changed["value" if name == "param" else found.attribute] = _NOWHERE
        super().startElement(name, AttributesImpl(changed))
