"""The scenarios of the runs from which the tables are made.

Everything that is scored here is held out: detectors are trained and calibrated on other networks (or, for the
column of the training networks in the generalisation table, on other seeds), and the two figures of the attacks that
the paper leaves open are pinned on the training networks before anything is scored.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gpsec.localization.registry import RESPONSES
from gpsec.paper.design import (
    AS_WRITTEN,
    CONSUMER_BIASES_M,
    CROWDED,
    CURVE_DELTAS,
    DIRECTIONS_DEG,
    EVALUATION,
    FURTHER_RATES,
    NONE,
    ODOMETER_FACTORS,
    ODOMETER_PROFILE,
    PAPER,
    PIN_DELTAS,
    PIN_NETWORK,
    PIN_SEEDS,
    SEEDS,
    SET_UPS,
    SIMULATED,
    SLOW_DELTA,
    SLOW_STEALTH,
    TABLE_I_DETECTORS,
    Group,
    Pinned,
    PlanTable,
    as_written,
    constant,
    lane_alias,
    pinned_plans,
    stealth,
    target_m,
)
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.choices import detectors, has_rate
from gpsec.scenario.networks import TRAINING_NETWORKS
from gpsec.types.points import HEADLINE_RATE, PER_SAMPLE


@dataclass(frozen=True)
class _Settings:
    """Settings of a run that are the same in most of them."""

    rate: str = PER_SAMPLE
    association: str = "tracked"
    duration_s: float | None = None
    equipped_share: float = 1.0
    log_steps: bool = False
    detectors: Sequence[str] | None = None
    odometer_factor: float = 1.0


@dataclass(frozen=True)
class Studies:
    """Makes the scenarios.

    Attributes:
        folder: of the scenarios that they are made from.
        quick: short runs and one seed, to see that everything works; intervals are wide then.
    """

    folder: Path
    quick: bool = False

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds of the main runs."""
        return SEEDS[:1] if self.quick else SEEDS

    @property
    def count(self) -> int:
        """Number of runs."""
        nothing = Pinned(dict.fromkeys(SET_UPS, 1.5), dict.fromkeys(SET_UPS, 1.0))
        return len(self.pin()) + len(self.benign()) + sum(len(group) for group in self.groups(nothing).values())

    def groups(self, pinned: Pinned) -> dict[Group, list[Scenario]]:
        """Return all runs that are scored, by what they are for."""
        groups: dict[Group, list[Scenario]] = {}
        # What takes longest comes first, so that no process waits for it at the end.
        for network in CROWDED:
            groups["mixed", "nearest", network] = [self.mixed(network, pinned, "nearest")]
        for network in (*reversed(EVALUATION), *TRAINING_NETWORKS):
            groups["mixed", "tracked", network] = [self.mixed(network, pinned)]
        for profile in SET_UPS:
            groups["main", profile] = self.main(profile, pinned)
            groups["nearest", profile] = self.nearest(profile, pinned)
            groups["curves", profile] = [self.curves(profile, pinned)]
            groups["logged", profile] = [self.logged(profile, pinned)]
            for rate in FURTHER_RATES:
                groups["rate", profile, rate] = self.at_rate(profile, rate, pinned)
            groups["written", profile] = self.as_written(profile, profile, pinned)
        for profile, simulated in SIMULATED.items():
            groups["written", simulated] = self.as_written(profile, simulated, pinned)
            groups["simulated", profile] = self.simulated(profile, pinned)
        for factor in ODOMETER_FACTORS:
            groups["odometer", f"{factor:g}"] = [self.odometer(factor, pinned)]
        groups["consumer",] = [self.consumer()]
        groups["places",] = [self.places(pinned)]
        return groups

    def pin(self) -> list[Scenario]:
        """Return the runs on a training network from which δ and the bias are chosen."""
        plans = [stealth(delta, f"stealth_{delta:g}") for delta in PIN_DELTAS]
        plans += [constant(target_m(profile), f"constant_{profile}") for profile in SET_UPS]
        seeds = PIN_SEEDS[:1] if self.quick else PIN_SEEDS
        return [self._make(f"pin-{seed}", PIN_NETWORK, _thirds(), seed, plans, _watched()) for seed in seeds]

    def main(self, profile: str, pinned: Pinned) -> list[Scenario]:
        """Return the runs of Table I and of one of Tables II-IV: every defence, attacks as pinned."""
        plans = [*pinned_plans(pinned, profile), stealth(SLOW_DELTA, SLOW_STEALTH)]
        return [
            self._make(f"main-{profile}-{seed}", SET_UPS[profile], profile, seed, plans, _all_defences())
            for seed in self.seeds
        ]

    def nearest(self, profile: str, pinned: Pinned) -> list[Scenario]:
        """Return the same with the paper's nearest-lane association, for Table I."""
        plans = pinned_plans(pinned, profile)
        return [
            self._make(
                f"nearest-{profile}-{seed}",
                SET_UPS[profile],
                profile,
                seed,
                plans,
                _watched(),
                _Settings(association="nearest"),
            )
            for seed in self.seeds[:2]
        ]

    def as_written(self, set_up: str, profile: str, pinned: Pinned) -> list[Scenario]:
        """Return the runs of the paper as written; `profile` is that of a set-up, or what its simulator gives."""
        plans = as_written(pinned.delta[set_up], pinned.bias_m[set_up])
        defences = [NONE, *((detector, AS_WRITTEN[1]) for detector in TABLE_I_DETECTORS)]
        settings = _Settings(association="nearest", detectors=TABLE_I_DETECTORS)
        return [
            self._make(f"written-{profile}-{seed}", SET_UPS[set_up], profile, seed, plans, defences, settings)
            for seed in self.seeds[:2]
        ]

    def simulated(self, set_up: str, pinned: Pinned) -> list[Scenario]:
        """Return runs with what a set-up's simulator gives, and the lane that the camera follows."""
        plans = as_written(pinned.delta[set_up], pinned.bias_m[set_up])
        defences = [NONE, AS_WRITTEN, PAPER, ("told", "ukf")]
        settings = _Settings(detectors=(AS_WRITTEN[0], PAPER[0]))
        return [
            self._make(
                f"simulated-{set_up}-{seed}", SET_UPS[set_up], SIMULATED[set_up], seed, plans, defences, settings
            )
            for seed in self.seeds[:2]
        ]

    def odometer(self, factor: float, pinned: Pinned) -> Scenario:
        """Return a run whose odometers are off by `factor` times what the filters take them to be."""
        plans = as_written(pinned.delta[ODOMETER_PROFILE], pinned.bias_m[ODOMETER_PROFILE])[:1]
        return self._make(
            f"odometer-{factor:g}",
            SET_UPS[ODOMETER_PROFILE],
            ODOMETER_PROFILE,
            SEEDS[0],
            plans,
            [NONE, ("told", "ukf")],
            _Settings(duration_s=240.0, detectors=(), odometer_factor=factor),
        )

    def at_rate(self, profile: str, rate: str, pinned: Pinned) -> list[Scenario]:
        """Return the runs of Table I with thresholds of another false-alarm rate."""
        plans = [*pinned_plans(pinned, profile), stealth(SLOW_DELTA, SLOW_STEALTH)]
        label = rate.replace("/", "-per-")
        return [
            self._make(
                f"rate-{label}-{profile}-{seed}",
                SET_UPS[profile],
                profile,
                seed,
                plans,
                _watched(),
                _Settings(rate=rate),
            )
            for seed in self.seeds[:2]
        ]

    def mixed(self, network: str, pinned: Pinned, association: str = "tracked") -> Scenario:
        """Return a run whose fleet is a third of each profile; every profile's attacks are there under its name."""
        plans = [plan for profile in SET_UPS for plan in pinned_plans(pinned, profile, f"_{profile}")]
        plans.append(lane_alias())
        return self._make(
            f"mixed-{association}-{network}",
            network,
            _thirds(),
            SEEDS[0],
            plans,
            _watched(),
            # There are so many vehicles that a part of the time does.
            _Settings(association=association, duration_s=240.0 if network in CROWDED else None),
        )

    def curves(self, profile: str, pinned: Pinned) -> Scenario:
        """Return a run with a sweep over δ and over the direction of the bias."""
        plans = [stealth(delta, f"stealth_{delta:g}") for delta in CURVE_DELTAS]
        bias_m = pinned.bias_m[profile]
        plans += [constant(bias_m, f"direction_{degrees:g}", degrees) for degrees in DIRECTIONS_DEG]
        return self._make(f"curves-{profile}", SET_UPS[profile], profile, SEEDS[0], plans, _curve_defences())

    def consumer(self) -> Scenario:
        """Return a run with consumer receivers, whose own error is metres."""
        plans = [constant(bias_m, f"constant_{bias_m:g}") for bias_m in CONSUMER_BIASES_M]
        plans.append(stealth(SLOW_DELTA, SLOW_STEALTH))
        return self._make("consumer", "slow_curve", "consumer", SEEDS[0], plans, _watched())

    def benign(self) -> list[Scenario]:
        """Return a run for each profile in which errors are compared with the filters' covariances."""
        networks = SET_UPS | {"consumer": "slow_curve"}
        return [
            self._make(f"benign-{profile}", network, profile, SEEDS[0], [], [NONE], _Settings(duration_s=240.0))
            for profile, network in networks.items()
        ]

    def logged(self, profile: str, pinned: Pinned) -> Scenario:
        """Return a short run of few vehicles with a log of every step, for the pictures of single vehicles."""
        return self._make(
            f"logged-{profile}",
            SET_UPS[profile],
            profile,
            SEEDS[0],
            pinned_plans(pinned, profile),
            [NONE, *[("lstm_glr", name) for name in _isolating()]],
            _Settings(duration_s=120.0, equipped_share=0.1, log_steps=True),
        )

    def places(self, pinned: Pinned) -> Scenario:
        """Return a run in a town with a log of every step, for what happens in junctions and lane changes."""
        return self._make(
            "places",
            "town",
            "carla",
            SEEDS[0],
            pinned_plans(pinned, "carla"),
            [NONE, PAPER],
            _Settings(duration_s=150.0, equipped_share=0.25, log_steps=True),
        )

    def _make(
        self,
        name: str,
        network: str,
        profile: str | Mapping[str, float],
        seed: int,
        plans: Sequence[PlanTable],
        defences: Sequence[tuple[str, str]],
        settings: _Settings = _Settings(),
    ) -> Scenario:
        base = load_scenario(self.folder / network)
        return Scenario.model_validate(
            {
                "name": name,
                "sumocfg": str(base.sumocfg),
                "seed": seed,
                "duration_s": 100.0 if self.quick else settings.duration_s,
                "log_steps": settings.log_steps,
                "fleet": {
                    "profile": profile,
                    "association": settings.association,
                    "equipped_share": settings.equipped_share,
                },
                "world": {"odometer_factor": settings.odometer_factor},
                "detection": {
                    "detectors": detectors() if settings.detectors is None else settings.detectors,
                    "rates": [settings.rate],
                },
                "defences": [_defence(detector, response, settings.rate) for detector, response in defences],
                "plans": plans,
                # Intervals are made of pooled events, not by the runs.
                "outcomes": {"bootstrap": 1},
            }
        )


def _defence(detector: str, response: str, rate: str) -> dict[str, str]:
    rate = rate if has_rate(detector) else HEADLINE_RATE
    return {"detector": detector, "response": response, "rate": rate}


def _thirds() -> dict[str, float]:
    return dict.fromkeys(SET_UPS, 1.0 / len(SET_UPS))


def _isolating() -> list[str]:
    return [name for name, response in RESPONSES.items() if response.isolates]


def _watched() -> list[tuple[str, str]]:
    """Return a defence for every detector."""
    return [NONE, *((detector, "ukf") for detector in detectors())]


def _all_defences() -> list[tuple[str, str]]:
    """Return every response behind the truth and behind the paper's detector, and the paper's behind all others."""
    isolating = _isolating()
    both = [(detector, response) for detector in ("told", "lstm_glr") for response in isolating]
    return list(dict.fromkeys([NONE, *both, *_watched()[1:]]))


def _curve_defences() -> list[tuple[str, str]]:
    return list(dict.fromkeys([*_watched(), *(("lstm_glr", response) for response in _isolating())]))
