"""Paths: the forms of SCENARIO, and paths that mean the same on another machine."""

from dataclasses import dataclass
from pathlib import Path

from gpsec.core import shipped
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.sumo.home import sumo_home

TOML_NAME = "gpsec.toml"

# What a path raises that no file system takes: too long, with a zero byte, in circles, of a user that there is not.
UNUSABLE = (OSError, ValueError, RuntimeError)


@dataclass(frozen=True)
class Found:
    """What a SCENARIO argument stands for.

    Attributes:
        toml: the gpsec.toml, None where there is none.
        folder: that relative paths start from.
        sumocfg: where it is known without reading the toml.
        name: default name of the scenario.
    """

    toml: Path | None
    folder: Path
    sumocfg: Path | None
    name: str


def find(argument: str | Path) -> Found:
    """Return what `argument` stands for: a folder, a `gpsec.toml`, any `.sumocfg`, or a scenario of gpsec by its name.

    Raises:
        GpsecError: it is none of these, or the folder does not say which configuration is meant.
    """
    path = Path(argument)
    try:
        path.resolve()
        there = path.exists()
    except UNUSABLE as error:
        raise GpsecError(f"{shown(argument)}: cannot be used as a path: {reason(error)}") from None
    if not there and path.name == str(argument) and (ours := shipped.scenarios() / path).is_dir():
        return _in_folder(ours)
    if not there:
        raise GpsecError(f"{shown(argument)}: no such file or folder{_meant(path)}")
    if path.is_dir():
        return _in_folder(path)
    if stem := _sumocfg_stem(path.name):
        return Found(None, path.parent, path, stem)
    if path.suffix == ".toml":
        return Found(path, path.parent, None, _folder_name(path.parent))
    found = path.suffix or path.name
    raise GpsecError(
        f"{argument}: expected a scenario folder, its {TOML_NAME} or a .sumocfg, found a file '{shown(found)}'"
    )


def only_sumocfg(folder: Path) -> Path:
    """Return the one `.sumocfg` in `folder`.

    Raises:
        GpsecError: there is none, or more than one.
    """
    found = sorted(path for path in folder.glob("*.sumocfg") if not path.is_dir())
    if len(found) == 1:
        return found[0]
    if not found:
        raise GpsecError(f"{folder}: expected one .sumocfg, found none; name it as `sumocfg` in {TOML_NAME}")
    names = shown(", ".join(path.name for path in found))
    raise GpsecError(f"{folder}: expected one .sumocfg, found {names}; name one as `sumocfg` in {TOML_NAME}")


def scenarios_in(folder: Path) -> list[Path]:
    """Return the scenario folders inside `folder`, by name."""
    if not folder.is_dir():
        return []
    return sorted(
        child
        for child in folder.iterdir()
        if child.is_dir() and ((child / TOML_NAME).is_file() or any(child.glob("*.sumocfg")))
    )


def expand(text: str, folder: Path) -> Path:
    """Return the absolute path of `text`: relative to `folder`, or with `~`, `$SUMO_HOME` or `$GPSEC` in front."""
    for prefix, base in (("$SUMO_HOME/", sumo_home), ("$GPSEC/", shipped.home)):
        if text.startswith(prefix):
            return (base() / text.removeprefix(prefix)).resolve()
    return (folder / Path(text).expanduser()).resolve()


def portable(path: Path, here: Path | None = None) -> str:
    """Return `path` as it means the same on another machine: relative to SUMO, to `here` or to gpsec if it can be."""
    for base, prefix in ((sumo_home().resolve(), "$SUMO_HOME/"), (here, ""), (shipped.home(), "$GPSEC/")):
        if base is not None and path.is_relative_to(base):
            return prefix + path.relative_to(base).as_posix()
    return path.as_posix()


def reason(error: Exception) -> str:
    """Return in a few words why a path cannot be used."""
    return (getattr(error, "strerror", None) or str(error)).rstrip(".").lower()


def _in_folder(folder: Path) -> Found:
    toml = folder / TOML_NAME
    if toml.is_file():
        return Found(toml, folder, None, _folder_name(folder))
    if not any(folder.glob("*.sumocfg")):
        inside = [path.name for path in scenarios_in(folder)]
        hint = f"; the folders {shown(', '.join(inside))} in it are scenarios" if inside else ""
        raise GpsecError(f"{folder}: expected a {TOML_NAME} or one .sumocfg, found neither{hint}")
    return Found(None, folder, only_sumocfg(folder), _folder_name(folder))


def _sumocfg_stem(name: str) -> str:
    """Return what stands before the ending of a SUMO configuration, empty where `name` is not that of one.

    Old ones end in ``.sumo.cfg``, and SUMO's own examples in ``.sumocfg.disabled`` where its tests leave them out.
    """
    for ending in (".sumocfg", ".sumocfg.xml", ".sumo.cfg", ".sumocfg.disabled"):
        if name.endswith(ending):
            return name.removesuffix(ending)
    return ""


def _folder_name(folder: Path) -> str:
    return folder.resolve().name


def _meant(path: Path) -> str:
    here = {str(found): found for found in [*scenarios_in(Path("scenarios")), *scenarios_in(path.parent)]}
    here |= {found.name: found for found in scenarios_in(shipped.scenarios())}
    for text, found in here.items():
        if found.name == path.name:
            return f"; did you mean '{shown(text)}'?"
    return f": {nearest(str(path), here)}" if here else ""
