"""What a page says of a scenario that was run: its settings, plans, notes and cost."""

from collections.abc import Mapping
from typing import Any

from gpsec.report.formatting import seconds
from gpsec.scenario.mismatch import WorldSection

# So many vehicles are named, where more saw pictures.
_NAMED = 10


def described(stated: dict[str, Any]) -> dict[str, Any]:
    """Return the facts that the page lists of a scenario: its settings, plans, notes and cost."""
    given = stated["configuration"]
    steps = stated["steps"] * stated["step_s"]
    plans = [
        {
            "name": plan["name"],
            "attack": plan["attack"],
            "where": "in its zone" if "shape_m" in plan else f"{plan['share']:.0%} of the vehicles",
            "parameters": ", ".join(f"{name} {_value(value)}" for name, value in plan["parameters"].items()),
        }
        for plan in stated["plans"]
    ]
    facts = {
        "traffic": f"{given['sumocfg']}, {seconds(steps)} in steps of {stated['step_s']:g} s, seed {stated['seed']}",
        "fleet": f"{stated['vehicles']} vehicles with sensors ({given['fleet']['equipped_share']:.0%} of those whose"
        f" type does not say), {stated['vehicle_steps']:,} vehicle-steps, at most {stated['peak_vehicles']} at a time",
        "sensor profiles": ", ".join(stated["profiles"]),
        "what filters and detectors do not know": _unknown(given.get("world", {})),
        **_pictured(stated),
        "lane association": given["fleet"]["association"],
        "scored and attacked": f"after {given['fleet']['settle_s']:g} s on the road",
        "false-alarm rates of the thresholds": ", ".join(given["detection"]["rates"]),
        "GNSS is used again": f"{given['localization']['hold_s']:g} s after the last alarm, once fixes have agreed for"
        f" {given['localization']['rejoin_s']:g} s",
        "intervals": f"{given['outcomes']['confidence']:.0%}, bootstrap of {given['outcomes']['bootstrap']} over"
        " vehicles; Wilson's for shares",
        "engine": given["engine"],
        "gpsec": f"{stated['gpsec_version']}, commit {stated['git_commit'] or 'unknown'},"
        f" libsumo {stated['versions']['libsumo']}",
    }
    security_s = sum(stated["stages_s"].values())
    cost = (
        f"SUMO {stated['sumo_s']:.1f} s, security layer {security_s:.1f} s,"
        f" {security_s / max(stated['vehicle_steps'], 1) * 1e6:.1f} µs for each vehicle and step"
    )
    return {"name": stated["scenario"], "facts": facts | {"cost": cost}, "plans": plans, "notes": stated["notes"]}


def _pictured(stated: Mapping[str, Any]) -> dict[str, str]:
    """Return which vehicles saw pictures, nothing where nobody did."""
    who = stated.get("pixels", {}).get("vehicles", {})
    if not who:
        return {}
    pictures, lanes = (sum(one[key] for one in who.values()) for key in ("pictures", "lanes"))
    named = ", ".join(list(who)[:_NAMED]) + (f" and {len(who) - _NAMED} more" if len(who) > _NAMED else "")
    weather = stated["configuration"]["fleet"]["camera"]["image_weather"]
    return {
        "lanes by rendered pictures": f"{named}: a lane in {lanes / max(pictures, 1):.1%} of {pictures:,} pictures"
        f" (weather {weather})"
    }


def _unknown(world: Mapping[str, Any]) -> str:
    """Return the keys of `[world]` that are not as filters and detectors take them to be."""
    known = {key: field.default for key, field in WorldSection.model_fields.items()}
    differing = [f"{key} {_value(value)}" for key, value in world.items() if value != known.get(key)]
    return ", ".join(differing) or "nothing: noise and map are as stated"


def _value(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
