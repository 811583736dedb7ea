"""Defaults < `gpsec.toml` < command line, validated."""

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from gpsec.attacks.plans import PlanConfig, plan_config
from gpsec.core.errors import GpsecError, shown
from gpsec.scenario.defaults import default_list
from gpsec.scenario.model import MAX_NAME, NAME, Scenario
from gpsec.scenario.outside import NOTHING, Outside, load_parts
from gpsec.scenario.overrides import Override, apply
from gpsec.scenario.paths import UNUSABLE, Found, expand, find, only_sumocfg, reason
from gpsec.scenario.validation_errors import dotted, origin, quoted, sentence
from gpsec.sensors.shipped_tapes import SUFFIX, load_tape


def load_scenario(argument: str | Path, overrides: Sequence[Override] = (), outside: Outside = NOTHING) -> Scenario:
    """Return the scenario that `argument` (a folder, its `gpsec.toml` or a `.sumocfg`) stands for.

    Args:
        argument: as on the command line.
        overrides: changes from the command line, in the order in which they are applied.
        outside: parts that are loaded beside those that the scenario names, and whether code that it names is run.

    Raises:
        GpsecError: a file is missing, a key or value is not one that there is, or the file names code.
    """
    found = find(argument)
    raw = _read(found.toml) if found.toml else {}
    return _validated(raw, found, str(found.toml or found.sumocfg or found.folder), overrides, outside)


def changed(scenario: Scenario, overrides: Sequence[Override], outside: Outside = NOTHING) -> Scenario:
    """Return a scenario with some keys changed, as `load_scenario` would: all others stay as they are resolved.

    Raises:
        GpsecError: a key or value is not one that there is, or does not go with the others.
    """
    if not overrides:
        return scenario
    found = Found(None, Path.cwd(), scenario.sumocfg, scenario.name)
    raw = scenario.model_dump(mode="json")
    raw["plans"] = [_beside(plan) for plan in raw["plans"]]
    return _validated(raw, found, f"scenario '{scenario.name}'", overrides, outside)


def _beside(plan: dict[str, Any]) -> dict[str, Any]:
    """Return a plan with the attack's own keys beside its own, as one writes it: there they can be changed by name."""
    own = {key: value for key, value in plan.items() if key != "parameters"}
    nested = {key: value for key, value in plan["parameters"].items() if key in own}
    return {**plan["parameters"], **own, **({"parameters": nested} if nested else {})}


def _validated(
    raw: dict[str, Any], found: Found, file: str, overrides: Sequence[Override], outside: Outside
) -> Scenario:
    """Return the scenario of the keys that `file` says, with changes; relative paths start from where it was found."""
    changes = [apply(raw, change, lambda key: default_list(key, raw)) for change in overrides]
    raw["sumocfg"] = _sumocfg(raw, found, file, changes)
    raw.setdefault("name", _as_name(raw["sumocfg"], found))
    _find_models(raw, found, file, changes)
    _find_tapes(raw, found, file, changes)
    _load_parts(raw, found, file, changes, outside)
    if isinstance(raw.get("plans"), list):
        raw["plans"] = [_plan(table, place, file, changes) for place, table in enumerate(raw["plans"])]
    try:
        return Scenario.model_validate(raw)
    except ValidationError as error:
        raise GpsecError(sentence(error, Scenario, file, changes)) from None


def _read(toml: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(toml.read_text(encoding="utf-8-sig"))  # Windows editors put a mark in front
    except UnicodeDecodeError:
        raise GpsecError(f"{toml}: expected TOML in UTF-8, found other bytes") from None
    except tomllib.TOMLDecodeError as error:
        raise GpsecError(f"{toml}: not valid TOML: {error}") from None
    except (ValueError, RecursionError) as error:
        raise GpsecError(f"{toml}: not valid TOML: {str(error).partition(';')[0]}") from None
    except OSError as error:
        raise GpsecError(f"{toml}: cannot be read: {error.strerror}") from None


def _sumocfg(raw: dict[str, Any], found: Found, file: str, overrides: list[Override]) -> Path:
    stated = raw.get("sumocfg")
    if stated is None:
        return (found.sumocfg or only_sumocfg(found.folder)).resolve()
    where = f"{origin(('sumocfg',), file, overrides)}: sumocfg"
    if not isinstance(stated, str):
        raise GpsecError(f"{where}: expected a path, found {quoted(stated)}")
    try:
        path = expand(stated, found.folder)
        there = path.is_file()
    except UNUSABLE as error:
        raise GpsecError(f"{where}: expected a path, found {quoted(stated)}: {reason(error)}") from None
    if not there:
        raise GpsecError(f"{where}: expected a .sumocfg, found no file {shown(path)}")
    return path


def _find_models(raw: dict[str, Any], found: Found, file: str, overrides: list[Override]) -> None:
    """Replace the folder of `detection.models` by its full path: from the scenario's folder, or in a flag from here."""
    section = raw.get("detection")
    stated = section.get("models") if isinstance(section, dict) else None
    if not isinstance(section, dict) or not isinstance(stated, str) or stated == "none":
        return
    key = ("detection", "models")
    source = origin(key, file, overrides)
    try:
        path = expand(stated, found.folder if source == file else Path())
        there = path.is_dir()
    except UNUSABLE as error:
        raise GpsecError(
            f"{source}: detection.models: expected a folder, found {quoted(stated)}: {reason(error)}"
        ) from None
    if not there:
        raise GpsecError(f"{source}: detection.models: expected a folder with models, found none at {shown(path)}")
    raw["detection"] = {**section, "models": str(path)}


def _find_tapes(raw: dict[str, Any], found: Found, file: str, overrides: list[Override]) -> None:
    """Replace the files of tapes by their full paths, and read them once: what is wrong with them is said now."""
    fleet = raw.get("fleet")
    if not isinstance(fleet, dict):
        return
    for sensor in ("camera", "gnss"):
        section = fleet.get(sensor)
        stated = section.get("tape") if isinstance(section, dict) else None
        if not isinstance(section, dict) or not isinstance(stated, str) or stated == "none":
            continue
        key = ("fleet", sensor, "tape")
        source = origin(key, file, overrides)
        try:
            if stated.endswith(SUFFIX):
                stated = str(expand(stated, found.folder if source == file else Path()))
            load_tape(stated)
        except UNUSABLE as error:
            said = f"expected a tape, found {quoted(stated)}: {reason(error)}"
            raise GpsecError(f"{source}: {dotted(key)}: {said}") from None
        except GpsecError as error:
            raise GpsecError(f"{source}: {dotted(key)}: {error}") from None
        raw["fleet"] = fleet = {**fleet, sensor: {**section, "tape": stated}}


def _load_parts(raw: dict[str, Any], found: Found, file: str, overrides: list[Override], outside: Outside) -> None:
    """Load the parts from outside gpsec, whose names the other keys may use."""
    stated = raw.get("parts", [])
    if not isinstance(stated, list) or not all(isinstance(reference, str) for reference in stated):
        return  # validation says what is wrong
    whole: list[str] = []
    for place, reference in enumerate(stated):
        source = origin(("parts", place), file, overrides)
        chosen, key = source != file, f"{source}: parts.{place}"
        whole += _loaded(reference, Path() if chosen else found.folder, chosen or outside.allow_code, key)
    for reference in outside.parts:
        whole += _loaded(reference, Path(), True, "--part")
    if whole:
        raw["parts"] = list(dict.fromkeys(whole))


def _loaded(reference: str, folder: Path, allowed: bool, where: str) -> tuple[str, ...]:
    try:
        return load_parts([reference], folder, allow_code=allowed)
    except ValueError as error:
        raise GpsecError(f"{where}: {error}") from None


def _as_name(sumocfg: Path, found: Found) -> str:
    for name in (found.name, sumocfg.stem):
        cleaned = re.sub(r"[^A-Za-z0-9._-]+", "_", name).strip("._-")[:MAX_NAME]
        if NAME.fullmatch(cleaned):
            return cleaned
    return "scenario"


def _plan(table: object, place: int, file: str, overrides: list[Override]) -> PlanConfig:
    key = ("plans", place)
    if not isinstance(table, dict):
        raise GpsecError(f"{origin(key, file, overrides)}: {dotted(key)}: expected a table, found {quoted(table)}")
    try:
        return plan_config(table, dotted(key))
    except GpsecError as error:
        # A flag that wrote another key of this plan is not to blame.
        suspects = [change for change in overrides if len(change.key) < 3 or str(change.key[-1]) in str(error)]
        raise GpsecError(f"{origin(key, file, suspects)}: {error}") from None
