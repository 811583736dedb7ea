"""Turns a validation error of pydantic into one sentence."""

from collections.abc import Iterator
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from gpsec.core.errors import nearest, shown
from gpsec.scenario.overrides import Key, Override

_EXPECTED = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "string_type": "a text",
    "bool_type": "true or false",
    "model_type": "a table",
    "dict_type": "a table",
    "mapping_type": "a table",
    "tuple_type": "a list",
    "list_type": "a list",
    "path_type": "a path",
    "date_type": "a date",
}
# What former keys have become.
_FORMER = {
    "detection.false_alarm_rate": "`rate` of each defence, and `rates` of [detection], at which detectors are scored",
}
_BOUNDS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


def sentence(error: ValidationError, model: type[BaseModel], file: str, overrides: list[Override]) -> str:
    """Return a sentence on the first error: where the value was written, its key, what was expected and found.

    Args:
        error: raised by `model`.
        model: what was validated.
        file: that the configuration came from.
        overrides: that were applied to it; one that wrote the key is named in place of the file.
    """
    first, *others = error.errors(include_url=False)
    key = tuple(first["loc"])
    more = f" (and {len(others)} more to correct)" if others else ""
    return f"{origin(key, file, overrides)}: {_message(first, key, model)}{more}"


def origin(key: Key, file: str, overrides: list[Override]) -> str:
    """Return where the value of `key` was written."""
    for override in reversed(overrides):
        shorter = min(len(key), len(override.key))
        if shorter and key[:shorter] == override.key[:shorter]:
            return override.flag
    return file


def dotted(key: Key) -> str:
    """Return `key` as the user writes it."""
    return ".".join(str(part) for part in key)


def _message(error: ErrorDetails, key: Key, model: type[BaseModel]) -> str:
    kind = error["type"]
    if kind == "extra_forbidden":
        if instead := _FORMER.get(dotted(key)):
            return f"{dotted(key)} is no longer a key; expected {instead}"
        choices = nearest(str(key[-1]), _keys_at(model, key[:-1]))
        where = f" in {dotted(key[:-1])}" if len(key) > 1 else ""
        return f"unknown key '{shown(key[-1])}'{where}: {choices}"
    said = _said(error)
    return f"{dotted(key)}: {said}" if key else said


def _said(error: ErrorDetails) -> str:
    kind, context, found = error["type"], error.get("ctx", {}), quoted(error["input"])
    if kind == "missing":
        return "is missing"
    if kind == "value_error":
        return str(context["error"])
    if kind == "literal_error":
        return f"expected {context['expected']}, found {found}{_literal_hint(context['expected'], error['input'])}"
    if kind in _BOUNDS:
        name, words = _BOUNDS[kind]
        return f"expected {words} {context[name]:g}, found {found}"
    if kind == "string_pattern_mismatch":
        return f"expected a text of the form {context['pattern']}, found {found}"
    if kind in _EXPECTED:
        return f"expected {_EXPECTED[kind]}, found {found}"
    return f"{error['msg'][:1].lower()}{error['msg'][1:]}, found {found}"


def _literal_hint(expected: str, found: Any) -> str:
    words = expected.replace(" or ", ", ").split(", ")
    hint = nearest(str(found), [word.strip("'") for word in words])
    return f"; {hint.partition(' (')[0]}" if hint.startswith("did") else ""


def quoted(value: Any) -> str:
    """Return `value` as the user would recognise it: texts in quotes, true and false as in TOML."""
    return shown(str(value).lower() if isinstance(value, bool) else repr(value))


def _keys_at(model: type[BaseModel], key: Key) -> list[str]:
    for part in key:
        if isinstance(part, int):
            continue
        field = model.model_fields.get(str(part))
        inner = next(_models_in(field.annotation), None) if field else None
        if inner is None:
            return []
        model = inner
    return list(model.model_fields)


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if get_origin(annotation) in (Annotated, Union, UnionType, tuple, list):
        for argument in get_args(annotation):
            yield from _models_in(argument)
    elif isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
