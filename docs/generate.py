"""Writes what is made from the code into the documentation: `python docs/generate.py`.

The tables of docs/scenario.md come from the models of `gpsec.toml`, and so does the JSON Schema beside it; those of
docs/sensors.md from the sensor profiles. Tests hold them against the code.
"""

import json
import re
from pathlib import Path
from typing import Any

from gpsec.scenario.schema import NESTED, SCHEMA_FILE, SECTIONS, json_schema, section_of
from gpsec.sensors.profiles import SensorProfile, Sourced
from gpsec.sensors.registry import PROFILES

DOCS = Path(__file__).parent
CHANNELS = ("map", "gnss", "gyro", "odometer", "heading", "camera")
_BLOCK = re.compile(r"(<!-- keys: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
_BOUNDS = {
    "minimum": "at least {:.10g}",
    "exclusiveMinimum": "above {:.10g}",
    "maximum": "at most {:.10g}",
    "exclusiveMaximum": "below {:.10g}",
}


def scenario_page(page: str) -> str:
    """Return docs/scenario.md with its tables written anew."""
    schema = json_schema()

    def block(found: re.Match[str]) -> str:
        part = section_of(schema, "" if found[2] == "top" else found[2])
        return f"{found[1]}\n{table(part)}\n{found[3]}"

    return _BLOCK.sub(block, page)


def table(section: dict[str, Any]) -> str:
    """Return the keys of a section as rows of Markdown; those that are sections themselves are left out."""
    rows = ["| key | default | values | meaning |", "|---|---|---|---|"]
    for key, says in section["properties"].items():
        if key in SECTIONS:
            continue
        if key in NESTED:
            rows += [row(f"{key}.{inner}", of, []) for inner, of in says["properties"].items()]
            continue
        rows.append(row(key, says, section.get("required", [])))
    return "\n".join(rows) + "\n"


def row(key: str, says: dict[str, Any], required: list[str]) -> str:
    """Return a key as a row."""
    default = "must be given" if key in required else _toml(says.get("default"))
    return f"| `{key}` | {default} | {_values(says)} | {says['description']} |"


def _toml(value: Any) -> str:
    if value is None:
        return "unset"
    if isinstance(value, dict):
        inner = ", ".join(f"{key} = {json.dumps(item)}" for key, item in value.items())
        return f"`{{ {inner} }}`" if inner else "`{}`"
    return f"`{json.dumps(value)}`"


def _values(says: dict[str, Any]) -> str:
    """Return which values the schema allows, in words."""
    if choices := says.get("enum"):
        return ", ".join(f"`{choice}`" for choice in choices)
    if says.get("type") in ("boolean", "array", "object"):
        return {"boolean": "`true`, `false`", "array": "a list", "object": "a table"}[says["type"]]
    if "anyOf" in says:
        return "a text or a table"
    bounds = ", ".join(form.format(says[key]) for key, form in _BOUNDS.items() if key in says)
    return bounds or "a text"


def sensors_page(page: str) -> str:
    """Return docs/sensors.md with its tables of figures and sources written anew."""
    for name, made in (("figures", _figures()), ("sources", _sources())):
        inside = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)", re.DOTALL)
        page = inside.sub(lambda found, made=made: f"{found[1]}\n{made}\n{found[2]}", page)
    return page


def _channel(profile: SensorProfile, name: str) -> Sourced:
    return profile if name == "map" else profile.channels()[name]


def _figures() -> str:
    lines = []
    for name in CHANNELS:
        channels = [_channel(profile, name) for profile in PROFILES.values()]
        lines += [
            f"### `{name}`",
            "",
            "| figure | " + " | ".join(PROFILES) + " |",
            "|---" + "|--:" * len(PROFILES) + "|",
        ]
        for figure in dict.fromkeys(figure for channel in channels for figure in channel.figures()):
            cells = (f"{channel.figures()[figure]:.10g}" if figure in channel.figures() else "" for channel in channels)
            lines.append(f"| `{figure}` | " + " | ".join(cells) + " |")
        lines.append("")
    return "\n".join(lines)


def _sources() -> str:
    lines = ["| profile | channel | figures | source |", "|---|---|---|---|"]
    for profile in PROFILES.values():
        for name in CHANNELS:
            channel = _channel(profile, name)
            by_source: dict[str, list[str]] = {}
            for figure in channel.figures():
                by_source.setdefault(channel.sources[figure], []).append(f"`{figure}`")
            lines += [
                f"| {profile.name} | {name} | {', '.join(figures)} | {source} |"
                for source, figures in by_source.items()
            ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the files."""
    sensors = DOCS / "sensors.md"
    sensors.write_text(sensors_page(sensors.read_text("utf-8")), "utf-8")
    page = DOCS / "scenario.md"
    page.write_text(scenario_page(page.read_text("utf-8")), "utf-8")
    (DOCS / SCHEMA_FILE).write_text(schema_text(), "utf-8")


def schema_text() -> str:
    """Return the schema as it stands in the file."""
    return json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    main()
