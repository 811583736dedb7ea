"""Every defence at several false-alarm rates, so that one run shows what each of them costs and saves."""

from collections.abc import Sequence

from gpsec.core.errors import GpsecError
from gpsec.scenario import choices
from gpsec.scenario.detection import Defence
from gpsec.scenario.model import Scenario


def with_rates(scenario: Scenario, rates: Sequence[str]) -> Scenario:
    """Return a scenario that scores its detectors at `rates`, and has each defence at all of them.

    Defences whose detector has no rate stay as they are; those that are the same at another rate fall together.

    Raises:
        GpsecError: there is no such rate.
    """
    try:
        known = tuple(dict.fromkeys(choices.require_rate(rate) for rate in rates))
    except ValueError as error:
        raise GpsecError(f"--rates: {error}") from None
    defences: dict[str, Defence] = {}
    for defence in scenario.defences:
        own = known if choices.has_rate(defence.detector) else (defence.rate,)
        for one in (defence.model_copy(update={"rate": rate}) for rate in own):
            defences.setdefault(one.name, one)
    detection = scenario.detection.model_copy(update={"rates": known})
    return scenario.model_copy(update={"detection": detection, "defences": tuple(defences.values())})
