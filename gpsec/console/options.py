"""Options that several commands have, and what they stand for."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.core.errors import GpsecError

if TYPE_CHECKING:
    from gpsec.scenario.overrides import Override

Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a key of gpsec.toml, such as fleet.profile=consumer."),
]
Scenarios = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENARIO", help="A scenario folder, its gpsec.toml, any .sumocfg, or a name of `gpsec list scenarios`."
    ),
]
Profile = Annotated[
    str | None, typer.Option("--profile", metavar="P", help="Sensor profile of the whole fleet (fleet.profile).")
]
Part = Annotated[
    list[str] | None,
    typer.Option(
        "--part", metavar="REF", help="Load a part: FILE.py:Name, package.module:Name, or a profile FILE.toml."
    ),
]
PlayedTapes = Annotated[
    list[str] | None,
    typer.Option("--tape", metavar="NAME", help="Errors that sensors play: a tape of gpsec, or FILE.npz; repeatable."),
]
RunsCode = Annotated[bool, typer.Option("--allow-code", help="Run the code that RUN's scenario names as `parts`.")]
AllowCode = Annotated[bool, typer.Option("--allow-code", help="Run the code that a scenario names under `parts`.")]


def changes(sets: list[str] | None, profile: str | None) -> "list[Override]":
    """Return what `--set` and `--profile` change, in the order in which it is applied.

    Raises:
        GpsecError: one of `sets` is not ``key=value``.
    """
    from gpsec.scenario.overrides import Override, parse_set

    found = [parse_set(text) for text in sets or []]
    if profile is not None:
        found.append(Override(("fleet", "profile"), profile, f"--profile {profile}"))
    return found


def load_given_parts(references: list[str] | None) -> tuple[str, ...]:
    """Load the parts that the command line names; return their references with whole paths.

    Raises:
        GpsecError: one cannot be loaded.
    """
    if not references:
        return ()
    from gpsec.scenario import outside

    try:
        return outside.load_parts(references, Path(), allow_code=True)
    except ValueError as error:
        raise GpsecError(f"--part: {error}") from None
