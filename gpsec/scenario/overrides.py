"""What a user changes of a scenario: `--set key=value`, flags that stand for a key, keywords in Python."""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from gpsec.core.errors import GpsecError, nearest, shown

Key = tuple[str | int, ...]


@dataclass(frozen=True)
class Override:
    """One change.

    Attributes:
        key: path into the configuration; numbers are positions in lists.
        value: the new value.
        flag: how the user wrote it, for messages.
    """

    key: Key
    value: Any
    flag: str


def parse_set(text: str) -> Override:
    """Return the change that ``--set text`` asks for; the value is TOML, a bare word is a string.

    Raises:
        GpsecError: `text` is not ``key=value``.
    """
    flag = f"--set {text}"
    dotted, equals, value = text.partition("=")
    parts = [part.strip() for part in dotted.split(".")]
    if not equals or not all(parts):
        raise GpsecError(f"{flag}: expected key=value with a dotted key, such as fleet.profile=consumer")
    return Override(_key(parts), _value(value.strip(), flag), flag)


def of_keywords(keywords: Mapping[str, Any]) -> list[Override]:
    """Return the changes that keywords ask for, such as ``seed=2, fleet={"profile": "dsd"}``.

    A name may be dotted. A table changes the keys of a section that it has, and ``plans={"drift": {"rate_mps": 0.3}}``
    those of a plan; models of pydantic and paths are taken for what they stand for.
    """
    changes: list[Override] = []
    for name, given in keywords.items():
        value = _plain(given)
        depth = _TABLES_OF.get(name, 1) if isinstance(value, dict) and "." not in name else 0
        changes += _changes(tuple(name.split(".")), value, depth)
    return changes


# Plans are a list of tables, whose names stand where the keys of a section do.
_TABLES_OF = {"plans": 2}


def _changes(path: tuple[str, ...], value: Any, depth: int) -> list[Override]:
    if depth and isinstance(value, dict):
        return [change for key, each in value.items() for change in _changes((*path, str(key)), each, depth - 1)]
    return [Override(_key(path), value, f"{'.'.join(path)}={shown(repr(value))}")]


def _plain(value: Any) -> Any:
    """Return a value as TOML would give it."""
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return str(value) if isinstance(value, Path) else value


def _key(parts: Sequence[str]) -> Key:
    return tuple(int(part) if part.isdecimal() else part for part in parts)


def _value(text: str, flag: str) -> Any:
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        if not text or text[0] in "[{\"'" or "\n" in text:
            raise GpsecError(f"{flag}: expected a TOML value after '=', found '{shown(text)}'") from None
        return text
    if len(table) > 1:
        raise GpsecError(f"{flag}: expected one value after '=', found several lines")
    return table["value"]


def apply(raw: dict[str, Any], override: Override, default_list: Callable[[str], list[Any] | None]) -> Override:
    """Write the change into `raw`; return it with positions in place of names.

    `default_list` gives what a list is where `raw` does not have it yet. A list is indexed by position, or by the
    `name` or `attack` of the table that is meant; the position after the last one appends.

    Raises:
        GpsecError: the key leads through something that is neither a table nor a list.
    """
    *path, last = override.key
    if path and path[0] not in raw:
        materialised = default_list(str(path[0]))
        if materialised is not None:
            raw[str(path[0])] = materialised
    here: Any = raw
    resolved: list[str | int] = []
    for part in path:
        found = _place(here, part, resolved, override)
        resolved.append(found)
        if isinstance(here, dict):
            here = here.setdefault(found, {})
        else:
            if found == len(here):
                here.append({})
            here = here[found]
    place = _place(here, last, resolved, override)
    if isinstance(place, int):
        here[place : place + 1] = [override.value]
    else:
        here[place] = override.value
    return replace(override, key=(*resolved, place))


def _place(here: Any, part: str | int, path: list[str | int], override: Override) -> str | int:
    """Return the key or position in `here` that `part` means; `path` leads to `here`."""
    if isinstance(here, dict):
        return str(part)
    where = ".".join(map(str, path))
    if not isinstance(here, list):
        raise GpsecError(f"{override.flag}: {where} is neither a table nor a list, found {shown(repr(here))}")
    if isinstance(part, int):
        if part > len(here):
            raise GpsecError(f"{override.flag}: expected a position from 0 to {len(here)} in {where}, found {part}")
        return part
    named = [item.get("name", item.get("attack")) if isinstance(item, dict) else None for item in here]
    if part not in named:
        known = nearest(part, [str(name) for name in named if name is not None])
        raise GpsecError(f"{override.flag}: {where} has nothing called '{shown(part)}': {known}")
    return named.index(part)
