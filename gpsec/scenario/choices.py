"""What a configuration can choose from: the names in the registries, asked for when they are needed."""

from collections.abc import Iterable, Mapping

from gpsec.core.errors import nearest, shown

# Defences only, not scored detectors: told the truth, and never in alarm.
BOUNDS = ("never", "told")


def attacks() -> list[str]:
    """Return the names of the attacks."""
    from gpsec.attacks.registry import ATTACKS

    return list(ATTACKS)


def fixed_attacks() -> list[str]:
    """Return the names of gpsec's own attacks that know nothing of detectors."""
    from gpsec.attacks.registry import ATTACKS

    return [name for name in ATTACKS.own if ATTACKS[name]().known() is None]


def detectors() -> list[str]:
    """Return the names of the detectors that are scored."""
    from gpsec.detection.registry import DETECTORS

    return [name for name in DETECTORS if name not in BOUNDS]


def responses() -> list[str]:
    """Return the names of the responses."""
    from gpsec.localization.registry import RESPONSES

    return list(RESPONSES)


def profiles() -> list[str]:
    """Return the names of the sensor profiles."""
    from gpsec.sensors.registry import PROFILES

    return list(PROFILES)


def weathers() -> list[str]:
    """Return the names of the weathers of rendered pictures."""
    from gpsec.imaging.pictures.weather import WEATHERS

    return list(WEATHERS)


def reactions() -> list[str]:
    """Return the names of the reactions of the closed loop."""
    from gpsec.steering.registry import REACTIONS

    return list(REACTIONS)


def dynamics() -> list[str]:
    """Return the names of the lateral dynamics of the closed loop."""
    from gpsec.steering.registry import DYNAMICS

    return list(DYNAMICS)


def check_steering(reaction: str, keys: Mapping[str, float], lateral: str, lateral_keys: Mapping[str, float]) -> None:
    """Check the parameters of a reaction and of lateral dynamics, both of which there are.

    Raises:
        GpsecError: one is unknown, or its value is not allowed.
    """
    if keys or lateral_keys:
        from gpsec.steering.registry import DYNAMICS, REACTIONS, build_part

        build_part(REACTIONS, reaction, keys)
        build_part(DYNAMICS, lateral, lateral_keys)


def false_alarm_rates() -> list[str]:
    """Return the rates that thresholds are calibrated to."""
    from gpsec.detection.calibration import RATES

    return list(RATES)


def require_rate(rate: str) -> str:
    """Return `rate`.

    Raises:
        ValueError: no threshold is calibrated to it; says the nearest, and those of the model of extreme values.
    """
    from gpsec.detection.calibration import RATES, nearest_rates

    if rate not in RATES:
        raise ValueError(f"unknown false-alarm rate '{shown(rate)}': {nearest_rates(rate)}")
    return rate


def has_rate(detector: str) -> bool:
    """Return whether the threshold of a detector is calibrated to a false-alarm rate."""
    from gpsec.detection.registry import DETECTORS

    return DETECTORS[detector].threshold is None


def require_known(kind: str, name: str, known: Iterable[str]) -> str:
    """Return `name`.

    Raises:
        ValueError: it is not among the `known` ones.
    """
    known = list(known)
    if name not in known:
        raise ValueError(f"unknown {kind} '{shown(name)}': {nearest(name, known)}")
    return name
