"""Renames roads and junctions for netconvert, and back in its net."""

import re
from xml.etree.ElementTree import Element

from gpsec.opendrive.netfile import ORIGINAL

# SUMO keeps these for lists, file names and lanes inside junctions.
_REFUSED = re.compile(r"""[\s|\\'";:,<>&{}]""")
_LINKS = ("predecessor", "successor")


def rename_for_netconvert(root: Element) -> dict[str, str]:
    """Give roads and junctions names that netconvert takes; return the map's own of those that changed.

    It refuses some characters, and makes "-1" and "1#0" of road "1", which no other road may be called then.
    """
    roads = [element.get("id", "") for element in root.iterfind("road")]
    junctions = [element.get("id", "") for element in root.iterfind("junction")]
    taken = {*roads, *junctions}
    new: dict[str, str] = {}
    for name in dict.fromkeys([*roads, *junctions]):
        if _REFUSED.search(name) or not name or _clashes(name, taken):
            new[name] = _free(name, taken)
            taken.add(new[name])
    if new:
        _write(root, new)
    return {written: name for name, written in new.items()}


def restore_names(net: Element, names: dict[str, str]) -> None:
    """Replace the new names by the map's own in the `origId` of a net's lanes."""
    for parameter in net.iter("param"):
        if parameter.get("key") == ORIGINAL:
            road, _, lane = parameter.get("value", "").rpartition("_")
            parameter.set("value", f"{names.get(road, road)}_{lane}")


def _clashes(name: str, taken: set[str]) -> bool:
    return name[1:] in taken if name.startswith("-") else name.partition("#")[0] in taken - {name}


def _free(name: str, taken: set[str]) -> str:
    free = _REFUSED.sub("_", name).replace("#", "_").lstrip("-") or "_"
    while free in taken:
        free += "_"
    return free


def _write(root: Element, new: dict[str, str]) -> None:
    for element in (*root.iterfind("road"), *root.iterfind("junction")):
        element.set("id", new.get(element.get("id", ""), element.get("id", "")))
        if element.get("junction") != "-1":  # in no junction
            _replace(element, ("junction",), new)
        for link in (item for tag in _LINKS for item in element.iterfind(f"link/{tag}")):
            _replace(link, ("elementId",), new)
        for connection in element.iterfind("connection"):
            _replace(connection, ("incomingRoad", "connectingRoad"), new)


def _replace(element: Element, keys: tuple[str, ...], new: dict[str, str]) -> None:
    for key in keys:
        if element.get(key) in new:
            element.set(key, new[element.get(key, "")])
