"""The JSON Schema of `gpsec.toml`, made from the models: what an editor completes and checks."""

import inspect
import re
from typing import Any

from pydantic import BaseModel

from gpsec.attacks.plans import PlanConfig
from gpsec.attacks.registry import ATTACKS
from gpsec.scenario import choices
from gpsec.scenario.closed_loop import ClosedWorld
from gpsec.scenario.detection import Defence
from gpsec.scenario.fleet import CameraSection, ReceiverSection
from gpsec.scenario.model import MAX_NAME, NAME, Scenario

SCHEMA_FILE = "gpsec.schema.json"
_TABLES = ("fleet", "world", "traffic", "detection", "localization", "outcomes", "closed_loop")
SECTIONS = (*_TABLES, "defences", "plans")
NESTED: dict[str, type[BaseModel]] = {"camera": CameraSection, "gnss": ReceiverSection}
"""Tables in the section `fleet`."""
_DIALECT = "http://json-schema.org/draft-07/schema#"
_ATTRIBUTE = re.compile(r"    ([a-z]\w*(?:, [a-z]\w*)*): (.*)")


def json_schema() -> dict[str, Any]:
    """Return the schema (draft 7, which editors of TOML know) of a whole `gpsec.toml`."""
    schema = _plain(Scenario)
    properties = schema["properties"]
    for key in _TABLES:
        part: Any = Scenario.model_fields[key].annotation
        properties[key] = _plain(part)
    shares = {name: {"type": "number", "exclusiveMinimum": 0, "maximum": 1} for name in choices.profiles()}
    profile = properties["fleet"]["properties"]["profile"]
    profile.pop("additionalProperties", None)
    profile.pop("type", None)
    profile["anyOf"] = [
        {"enum": choices.profiles()},
        {"type": "object", "properties": shares, "additionalProperties": False, "minProperties": 1},
    ]
    for key, nested in NESTED.items():
        properties["fleet"]["properties"][key] = _plain(nested)
    detection = properties["detection"]["properties"]
    detection["detectors"] |= {"items": {"enum": choices.detectors()}, "uniqueItems": True}
    detection["rates"] |= {"items": {"enum": choices.false_alarm_rates()}, "uniqueItems": True, "minItems": 1}
    world = _plain(ClosedWorld)
    world["properties"]["on_alarm"]["enum"] = choices.reactions()
    closed = properties["closed_loop"]["properties"]
    closed["world"].pop("$ref", None)
    closed["world"] |= {"type": "object", "properties": world["properties"], "additionalProperties": False}
    closed["worlds"] |= {"items": world}
    closed["on_alarm"]["enum"], closed["dynamics"]["enum"] = choices.reactions(), choices.dynamics()
    defence = _plain(Defence)
    defence["properties"]["detector"]["enum"] = [*choices.BOUNDS, *choices.detectors()]
    defence["properties"]["response"]["enum"] = choices.responses()
    defence["properties"]["rate"]["enum"] = choices.false_alarm_rates()
    properties["defences"] = {"type": "array", "items": defence, "description": _first_line(Defence)}
    plans = {"oneOf": [_plan(name) for name in ATTACKS]}
    properties["plans"] = {"type": "array", "items": plans, "description": _first_line(PlanConfig)}
    properties["name"] |= {"pattern": f"^{NAME.pattern}$", "maxLength": MAX_NAME}
    schema.pop("required", None)  # what is not in the file has a value by the time that the model is made
    return {"$schema": _DIALECT, "title": "gpsec.toml", **schema}


def descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Return what the docstrings of `model` and of its bases say of each attribute."""
    said: dict[str, str] = {}
    for part in reversed(model.__mro__):
        if not issubclass(part, BaseModel) or part is BaseModel:
            continue
        keys: list[str] = []
        for line in inspect.cleandoc(part.__doc__ or "").partition("Attributes:\n")[2].splitlines():
            if found := _ATTRIBUTE.fullmatch(line):
                keys = found[1].split(", ")
                said |= dict.fromkeys(keys, found[2])
            elif keys and line.startswith("        "):
                said |= {key: f"{said[key]} {line.strip()}" for key in keys}
            else:
                keys = []
    return {key: text.rstrip(".").replace("``", "`") for key, text in said.items() if key in model.model_fields}


def _first_line(model: type[BaseModel]) -> str:
    return (model.__doc__ or "").partition("\n")[0]


def _plain(model: type[BaseModel]) -> dict[str, Any]:
    """Return the schema of a model by itself: described, without null, which TOML has not, and without references."""
    made = model.model_json_schema(mode="validation")
    said = descriptions(model)
    properties = {key: _property(key, made["properties"][key], said) for key in model.model_fields}
    schema: dict[str, Any] = {"type": "object", "description": _first_line(model), "properties": properties}
    if made.get("required"):
        schema["required"] = made["required"]
    return schema | {"additionalProperties": False}


def _property(key: str, made: dict[str, Any], said: dict[str, str]) -> dict[str, Any]:
    kept = {name: value for name, value in made.items() if name not in ("title", "format", "$ref")}
    if kept.get("default", 0) in (None, ""):
        del kept["default"]
    kinds = [kind for kind in kept.pop("anyOf", []) if kind.get("type") != "null"]
    for kind in kinds:
        kept |= kind
    return ({"description": said[key]} if key in said else {}) | kept


def _plan(name: str) -> dict[str, Any]:
    common, own = _plain(PlanConfig), _plain(ATTACKS[name])
    properties = common["properties"]
    properties["attack"] = {"const": name, "description": properties["attack"].get("description", "")}
    for key in ("start_after_s", "duration_s"):
        properties[key] = _window(properties[key])
    return common | {
        "title": name,
        "description": _first_line(ATTACKS[name]),
        "properties": properties | own["properties"],
        "required": ["attack"],
    }


def _window(made: dict[str, Any]) -> dict[str, Any]:
    bounds = {"type": "number", "minimum": 0}
    return {"description": made["description"], "default": list(made["default"])} | {
        "type": "array",
        "items": bounds,
        "minItems": 2,
        "maxItems": 2,
    }


def section_of(schema: dict[str, Any], name: str) -> dict[str, Any]:
    """Return the part of `json_schema` on a section; the empty name stands for the top of the file.

    A plan's part is that which all attacks share.
    """
    if name == "plans":
        return _plain(PlanConfig)
    part: dict[str, Any] = schema["properties"][name] if name else schema
    return part.get("items", part)  # type: ignore[no-any-return]
