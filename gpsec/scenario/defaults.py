"""Default lists of plans and defences."""

from collections.abc import Mapping
from typing import Any

from gpsec.scenario import choices
from gpsec.scenario.detection import DetectionSection


def default_list(key: str, raw: Mapping[str, Any]) -> list[Any] | None:
    """Return what the list `key` holds in the configuration `raw` that does not state it.

    `plans`: every attack of gpsec that knows nothing of detectors, with its defaults, each on half of the fleet.
    `defences`: the bounds of every table, then the paper's mitigation behind each detector that `raw` scores. None for
    any other key.
    """
    if key == "plans":
        return [{"attack": name, "share": 0.5} for name in choices.fixed_attacks()]
    if key == "defences":
        bounds = [{"detector": "never", "response": "none"}, {"detector": "told", "response": "ukf"}]
        return [*bounds, *({"detector": name, "response": "ukf"} for name in _scored(raw))]
    return None


def _scored(raw: Mapping[str, Any]) -> list[Any]:
    section = raw.get("detection")
    if isinstance(section, DetectionSection):
        return list(section.detectors)
    stated = section.get("detectors") if isinstance(section, Mapping) else None
    return list(stated if isinstance(stated, list | tuple) else DetectionSection().detectors)
