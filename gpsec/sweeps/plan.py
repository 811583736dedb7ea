"""The file of a sweep: which scenarios, with which seeds, with what changed."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from gpsec.core.errors import GpsecError, shown
from gpsec.running.seeds import parse_seeds
from gpsec.scenario.base import Section
from gpsec.scenario.validation_errors import sentence

SweepGrid = dict[str, list[Any]]
"""Dotted key of `gpsec.toml` -> its values."""


class SweepEntry(Section):
    """Runs that belong together: every scenario with every seed and every combination of the grid.

    Attributes:
        name: of the entry, a column of all tables; no two have the same.
        scenarios: as for `gpsec run`; paths start from the folder of the plan.
        seeds: such as `"1-20"` or `[1, 4, 7]`; unset takes each scenario's own.
        set: keys of `gpsec.toml` that are changed in all of its runs.
        grid: keys of `gpsec.toml`, each with a list of values.
        closed_loop: run the worlds of `closed_loop.worlds` instead of the scenario in open loop.
    """

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$", max_length=60)
    scenarios: Annotated[tuple[str, ...], Field(min_length=1, strict=False)]
    seeds: Annotated[tuple[Annotated[int, Field(ge=0, le=2**31 - 1)], ...], Field(strict=False)] = ()
    set: Mapping[str, Any] = Field({})
    grid: SweepGrid = Field({})
    closed_loop: bool = False

    @field_validator("seeds", mode="before")
    @classmethod
    def _parsed(cls, seeds: Any) -> Any:
        try:
            return parse_seeds(seeds) if isinstance(seeds, str) else seeds
        except GpsecError as error:
            raise ValueError(str(error).removeprefix("seeds: ")) from None

    @field_validator("grid", mode="before")
    @classmethod
    def _flat(cls, grid: Any) -> Any:
        return dict(_leaves(grid, "")) if isinstance(grid, Mapping) else grid

    @field_validator("grid")
    @classmethod
    def _has_values(cls, grid: SweepGrid) -> SweepGrid:
        for key, values in grid.items():
            if not values:
                raise ValueError(f"{shown(key)}: expected a list of values, found an empty one")
            for place, value in enumerate(values):
                if value in values[:place]:
                    raise ValueError(f"{shown(key)}: expected each value once, found {shown(repr(value))} twice")
            if key in ("seed", "name"):
                raise ValueError(f"{key}: expected a key that may vary; seeds are listed in `seeds`")
        return grid

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        for key, values in (("seeds", self.seeds), ("scenarios", self.scenarios)):
            if len(set(values)) < len(values):
                raise ValueError(f"{key}: expected each once, found {shown(list(values))}")
        return self


class SweepPlan(Section):
    """What a sweep runs.

    Attributes:
        set: keys of `gpsec.toml` that are changed in all runs.
        parts: attacks, detectors, responses and profiles from outside gpsec; see `parts` of `gpsec.toml`.
        entries: one or more.
    """

    set: Mapping[str, Any] = Field({})
    parts: Annotated[tuple[str, ...], Field(strict=False)] = ()
    entries: Annotated[tuple[SweepEntry, ...], Field(min_length=1, strict=False)]

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        names = [entry.name for entry in self.entries]
        for place, name in enumerate(names):
            if name in names[:place]:
                raise ValueError(f"entries: two entries are called '{shown(name)}'; give one of them another name")
        return self

    @property
    def parameters(self) -> dict[str, str]:
        """Keys that vary, in the order in which the plan names them, and what they are: number, flag or text."""
        values: dict[str, list[Any]] = {}
        for entry in self.entries:
            for key, some in entry.grid.items():
                values.setdefault(key, []).extend(some)
        return {key: _kind(some) for key, some in values.items()}


def _kind(values: list[Any]) -> str:
    if all(isinstance(value, bool) for value in values):
        return "flag"
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    return "number" if numbers else "text"


def read_plan(path: Path) -> SweepPlan:
    """Return the plan in a file of TOML.

    Raises:
        GpsecError: it is not there, is no TOML, or has a key or value that there is not.
    """
    try:
        raw = tomllib.loads(path.read_text("utf-8-sig"))
    except OSError as error:
        raise GpsecError(f"{path}: expected the plan of a sweep, found none: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise GpsecError(f"{path}: not valid TOML: {shown(error)}") from None
    try:
        return SweepPlan.model_validate(raw)
    except ValidationError as error:
        raise GpsecError(sentence(error, SweepPlan, str(path), [])) from None


def _leaves(table: Mapping[str, Any], before: str) -> list[tuple[str, Any]]:
    """Return dotted key and value of all that is no table in nested tables."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        name = f"{before}{key}"
        found += _leaves(value, f"{name}.") if isinstance(value, Mapping) else [(name, value)]
    return found
