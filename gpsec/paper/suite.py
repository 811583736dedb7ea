"""The standard suite of `gpsec bench-detector`: the same networks, seeds, attackers and worlds for every detector."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gpsec.attacks.plans import PlanConfig, plan_config
from gpsec.core import shipped
from gpsec.outcomes.naming import seeded_name
from gpsec.paper.stress import FACTORS
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.scenario.load import changed
from gpsec.scenario.networks import TRAINING_NETWORKS
from gpsec.scenario.outside import Outside
from gpsec.scenario.overrides import Override
from gpsec.types.points import point_name

RESPONSE = "ukf5_rollback"
AS_KNOWN = "nothing"
_SHORT = {"start_after_s": [0.0, 10.0], "duration_s": [20.0, 20.0]}
_LONG = {"start_after_s": [0.0, 0.0], "duration_s": [600.0, 600.0]}
# The attackers that know no detector, by name; the worlds that differ have the second alone.
_BLINDFOLD: Mapping[str, Mapping[str, Any]] = {
    "constant_bias": {"attack": "constant_bias", "bias_m": 2.4, "share": 0.5, **_SHORT},
    "stealth": {"attack": "stealth", "share": 0.5, **_SHORT},
    "drift": {"attack": "drift", "rate_mps": 0.2, "share": 0.5, **_SHORT},
    "patient": {"attack": "drift", "rate_mps": 0.015, "share": 0.5, **_LONG},
    "blind": {"attack": "blind_drift", "rate_mps": 1.0, "share": 0.5, **_SHORT},
}
_IN_OTHER_WORLDS = "stealth"
# Trying fixes costs what 45 detectors cost, so that few vehicles have such an attacker.
_KNOWING = {"attack": "adaptive", "share": 0.15, **_SHORT}


@dataclass(frozen=True)
class Suite:
    """What a detector is put through.

    Attributes:
        name: of the suite; rows of two suites are not compared.
        networks: that it is measured on, none of which anything is trained on.
        seeds: of each.
        duration_s: simulated time of a run.
        rates: of false alarms that it is measured at, the first for the table.
        worlds: factors of `gpsec.paper.stress`, run on the last of the networks.
        training: networks that it learns and is calibrated on.
        hours: of benign driving that 0.1 false alarms an hour are calibrated on, 0 for what training has.
    """

    name: str
    networks: tuple[str, ...]
    seeds: tuple[int, ...]
    duration_s: float
    rates: tuple[str, ...]
    worlds: tuple[str, ...]
    training: tuple[str, ...]
    hours: float

    @property
    def attacks(self) -> tuple[str, ...]:
        """Names of the attackers, in the order of the rows."""
        return (*_BLINDFOLD, "adaptive_hold", "adaptive_move")


STANDARD = Suite(
    name="1",
    networks=("town", "highway", "sharp_turns"),
    seeds=(1, 2, 3),
    duration_s=90.0,
    rates=("0.1/h", "1/h"),
    worlds=("gnss_2", "camera_2", "map_0.2"),
    training=TRAINING_NETWORKS,
    hours=300.0,
)
QUICK = Suite("quick", ("sharp_turns",), (1, 2), 60.0, ("1/h",), (), ("suburb",), 0.0)


@dataclass(frozen=True)
class Candidate:
    """A detector in the suite, with what it was calibrated to.

    Attributes:
        detector: its name.
        parts: its reference, where it is no part of gpsec.
        models: folder of what it has learned; None for what gpsec comes with.
        profile: sensor profile of the fleet.
    """

    detector: str
    parts: tuple[str, ...]
    models: Path | None
    profile: str


def suite_runs(suite: Suite, candidate: Candidate) -> dict[str, list[Scenario]]:
    """Return the runs of a suite, by the world that they are in."""
    found = {AS_KNOWN: list(_runs(suite, candidate, AS_KNOWN, suite.networks))}
    return found | {world: list(_runs(suite, candidate, world, suite.networks[-1:])) for world in suite.worlds}


def _runs(suite: Suite, candidate: Candidate, world: str, networks: Sequence[str]) -> Iterator[Scenario]:
    plans = _plans(suite, candidate.detector, knowing=world == AS_KNOWN)
    defences = [Defence(detector=candidate.detector, response=RESPONSE, rate=rate) for rate in suite.rates]
    keys = [Override(("world", key), value, f"factor {world}") for key, value in FACTORS[world].world.items()]
    keys.append(Override(("fleet", "profile"), candidate.profile, f"--profile {candidate.profile}"))
    for network in networks:
        folder = shipped.scenarios() / network
        found = changed(load_scenario(folder, (), Outside(candidate.parts)), keys)
        models = None if candidate.models is None else str(candidate.models)
        detection = {"detectors": (candidate.detector,), "rates": suite.rates, "models": models}
        update = {
            "duration_s": suite.duration_s,
            "detection": found.detection.model_copy(update=detection),
            "defences": (Defence(detector="never", response="none"), *defences),
            "plans": plans,
            "outcomes": found.outcomes.model_copy(update={"bootstrap": 10}),
        }
        for seed in suite.seeds:
            name = seeded_name(f"{network}-{world}", seed)
            yield found.model_copy(update=update | {"name": name, "seed": seed})


def blind_plans() -> tuple[PlanConfig, ...]:
    """Return the attackers of the suite that know no detector."""
    return tuple(plan_config({"name": name, **table}, "suite") for name, table in _BLINDFOLD.items())


def _plans(suite: Suite, detector: str, *, knowing: bool) -> tuple[PlanConfig, ...]:
    tables = {name: table for name, table in _BLINDFOLD.items() if knowing or name == _IN_OTHER_WORLDS}
    if knowing:
        for rate in suite.rates:
            for junctions in ("hold", "move"):
                own = {"target": point_name(detector, rate), "junctions": junctions}
                tables[f"adaptive_{junctions}@{rate}"] = _KNOWING | own
    return tuple(plan_config({"name": name, **table}, "suite") for name, table in tables.items())
