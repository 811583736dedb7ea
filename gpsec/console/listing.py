"""The answers of `gpsec list`: a line a part, its name first."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from gpsec.console import options
from gpsec.console.errors import say
from gpsec.core.errors import GpsecError, nearest

KINDS = ("attacks", "detectors", "responses", "profiles", "reactions", "dynamics", "scenarios")


def list_(
    kind: Annotated[
        str | None, typer.Argument(metavar="[KIND]", help=f"One of {', '.join(KINDS)}. [default: list these]")
    ] = None,
    folder: Annotated[
        Path | None,
        typer.Option("--dir", metavar="DIR", help="Where scenarios are. [default: ./scenarios, and those of gpsec]"),
    ] = None,
    part: options.Part = None,
) -> None:
    """List what there is to choose from.

    \b
    Examples:
      gpsec list
      gpsec list attacks
      gpsec list scenarios --dir scenarios
    """  # noqa: D301
    options.load_given_parts(part)
    for line in KINDS if kind is None else lines(kind, folder):
        say(line)


def lines(kind: str, folder: Path | None) -> list[str]:
    """Return a line for every part of one of `KINDS`; scenarios are those inside `folder`, or else those of gpsec.

    Raises:
        GpsecError: there is no such kind, or no scenario.
    """
    if kind == "scenarios":
        return _columns(_scenarios(folder))
    if kind not in KINDS:
        raise GpsecError(f"KIND: unknown '{kind}': {nearest(kind, KINDS)}")
    parts: Mapping[str, Any]
    if kind in ("attacks", "reactions", "dynamics"):
        parts = _with_parameters(kind)
        return _columns((name, f"{_first_line(part)} ({_parameters(part)})") for name, part in parts.items())
    if kind == "detectors":
        from gpsec.detection.registry import DETECTORS

        parts = DETECTORS
    elif kind == "responses":
        from gpsec.localization.registry import RESPONSES

        parts = RESPONSES
    else:
        from gpsec.sensors.registry import PROFILES

        parts = PROFILES
    return _columns((name, _first_line(part)) for name, part in parts.items())


def _with_parameters(kind: str) -> Mapping[str, Any]:
    if kind == "attacks":
        from gpsec.attacks.registry import ATTACKS

        return ATTACKS
    from gpsec.steering.registry import DYNAMICS, REACTIONS

    return REACTIONS if kind == "reactions" else DYNAMICS


def _scenarios(folder: Path | None) -> Iterable[tuple[str, str]]:
    from gpsec.core import shipped
    from gpsec.scenario.paths import scenarios_in

    if folder is None:
        found = [*scenarios_in(Path("scenarios")), *scenarios_in(shipped.scenarios())]
        return [(path.name, str(path)) for path in {path.resolve(): path for path in reversed(found)}.values()][::-1]
    found = scenarios_in(folder)
    if not found:
        raise GpsecError(f"{folder}: expected folders with a gpsec.toml or a .sumocfg, found none; name another --dir")
    return [(path.name, str(path)) for path in found]


def _parameters(part: Any) -> str:
    fields = part.model_fields.items()
    return ", ".join(f"{name} = {field.default!r}" for name, field in fields) or "no parameters"


def _first_line(part: Any) -> str:
    said = getattr(part, "description", None) or getattr(part, "title", None) or part.__doc__ or ""
    return str(said).strip().partition("\n")[0]


def _columns(rows: Iterable[tuple[str, str]]) -> list[str]:
    listed = list(rows)
    width = max((len(name) for name, _ in listed), default=0)
    return [f"{name:<{width}}  {text}".rstrip() for name, text in listed]
