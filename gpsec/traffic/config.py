"""Reads a SUMO configuration without SUMO, as SUMO would."""

import os
from dataclasses import dataclass
from difflib import get_close_matches
from math import isfinite
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

from gpsec.core.errors import GpsecError, shown
from gpsec.sumo.home import expand_variables
from gpsec.traffic.inputs import UNREADABLE
from gpsec.traffic.optiontable import SumoOption, sumo_options_by_name

GUI_TOPIC = "gui_only"
# Any other name of the root stands for a configuration, as it does for SUMO.
_OTHER_FILES = {"net": "a net", "routes": "a route file", "additional": "an additional file"}


@dataclass(frozen=True)
class SumoConfig:
    """What a configuration says, under the canonical names of the options.

    Attributes:
        path: absolute path of the configuration.
        values: value of each option that sumo knows, its variables expanded.
        gui_only: names of the options that only sumo-gui uses, in file order.
    """

    path: Path
    values: dict[str, str]
    gui_only: tuple[str, ...]

    def paths(self, name: str) -> list[Path]:
        """Return the files that the option `name` lists, absolute; they need not exist."""
        paths: list[Path] = []
        for item in self.values.get(name, "").split(","):
            whole = self._path(item)
            parts = item.replace(";", " ").split()
            # SUMO 1.28 separates by commas alone; older versions took semicolons and blanks too.
            if len(parts) > 1 and not is_file(whole):
                paths += [self._path(part) for part in parts]
            elif parts:
                paths.append(whole)
        return paths

    def is_on(self, name: str) -> bool:
        """Return whether the option `name`, a switch, is on."""
        return self.values.get(name, "").lower() in {"true", "1", "yes", "on", "x", "t"}

    def number(self, name: str, default: float) -> float:
        """Return the number under the option `name`.

        Raises:
            GpsecError: it is none.
        """
        text = self.values.get(name, "")
        try:
            return float(text) if text else default
        except ValueError:
            raise GpsecError(f"{self.path}: option '{name}': expected a number, found '{shown(text)}'") from None

    def seconds(self, name: str, default: float) -> float:
        """Return the time (s) under the option `name`: seconds, h:m:s or d:h:m:s.

        Raises:
            GpsecError: it is none.
        """
        text = self.values.get(name, "")
        parts = text.removeprefix("-").split(":")
        try:
            if len(parts) not in (1, 3, 4):
                raise ValueError
            if not all(isfinite(float(part)) for part in parts):
                raise ValueError
            seconds = sum(float(part) * unit for part, unit in zip(reversed(parts), (1, 60, 3600, 86400), strict=False))
        except ValueError:
            if not text:
                return default
            raise GpsecError(
                f"{self.path}: option '{name}': expected seconds or h:m:s, found '{shown(text)}'"
            ) from None
        return -seconds if text.startswith("-") else seconds

    def _path(self, item: str) -> Path:
        name = unquote(item.strip())
        given = Path(name).expanduser() if name.startswith("~/") else Path(name)
        return Path(os.path.normpath(self.path.parent / given))


def read_config(path: Path) -> SumoConfig:
    """Read the configuration at `path`.

    Raises:
        GpsecError: it is missing, is no XML, gives an option twice, or has one that no SUMO program knows.
    """
    path = Path(path).absolute()
    if not is_file(path):
        raise GpsecError(f"{path}: SUMO configuration not found{_nearby(path)}")
    try:
        root = ElementTree.parse(path).getroot()
    except UNREADABLE as error:
        raise GpsecError(f"{path}: expected a SUMO configuration in XML, found: {error}") from None
    if root.tag in _OTHER_FILES:
        raise GpsecError(f"{path}: expected a SUMO configuration, found {_OTHER_FILES[root.tag]} (<{root.tag}>)")
    known = sumo_options_by_name()
    values: dict[str, str] = {}
    gui_only: list[str] = []
    for topic, element in _leaves(root, ""):
        option = known.get(element.tag)
        if topic == GUI_TOPIC or (option is not None and option.topic == GUI_TOPIC):
            gui_only.append(element.tag)
            continue
        if option is None:
            raise GpsecError(_unknown_option(path, element.tag, topic, known))
        if option.name in values:
            raise GpsecError(f"{path}: option '{option.name}' is given twice")
        values[option.name] = expand_variables(element.get("value", element.get("v", element.text or "")).strip())
    return SumoConfig(path, values, tuple(gui_only))


def is_file(path: Path) -> bool:
    """Return whether there is a file at `path`; there is none under a name that no file system takes."""
    try:
        return path.is_file()
    except OSError:
        return False


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:
        return False


def missing_file(config: SumoConfig, key: str, path: Path) -> GpsecError:
    """Return the error for a `path` under `key` at which there is no file."""
    what = "is a folder: expected a file" if _is_folder(path) else f"does not exist{_nearby(path)}"
    return GpsecError(f"{config.path}: {key} names '{shown(path)}', which {what}")


def _leaves(parent: ElementTree.Element, topic: str) -> list[tuple[str, ElementTree.Element]]:
    found: list[tuple[str, ElementTree.Element]] = []
    for element in parent:
        is_topic = len(element) > 0 or not (element.attrib or (element.text or "").strip())
        found += _leaves(element, element.tag) if is_topic else [(topic, element)]
    return found


def _unknown_option(path: Path, name: str, topic: str, known: dict[str, SumoOption]) -> str:
    close = get_close_matches(name, known, n=1, cutoff=0.5)
    place = f" in <{shown(topic)}>" if topic else ""
    hint = f": did you mean '{shown(close[0])}'?" if close else ""
    return f"{path}: option '{shown(name)}'{place} is not known to SUMO{hint}"


def _nearby(path: Path) -> str:
    """Say which file beside `path` may have been meant: one of the same kind, or of nearly the same name."""
    try:
        if not path.parent.is_dir():
            return f" (there is no folder '{shown(path.parent)}')"
        names = sorted(entry.name for entry in path.parent.iterdir())
    except OSError:
        return ""
    stem, _, ending = path.name.partition(".")
    alike = {name.partition(".")[0]: name for name in names if ending and name.partition(".")[2] == ending}
    close = [alike[found] for found in get_close_matches(stem, alike, n=1, cutoff=0.6)]
    close = close or get_close_matches(path.name, names, n=1, cutoff=0.8)
    if close:
        return f": did you mean '{shown(close[0])}'?"
    return f" (of this kind there are: {shown(', '.join(alike.values()))})" if alike else ""
