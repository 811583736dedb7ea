"""When a plan attacks which vehicle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from math import ceil
from typing import NamedTuple

import numpy as np

from gpsec.attacks.base import Attack
from gpsec.attacks.plans import PlanConfig
from gpsec.attacks.zones import NOBODY, Zone
from gpsec.core import noise
from gpsec.core.arrays import Flags, Floats, Ints, Keys
from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.tables import blank

NOWHERE: Mapping[str, Zone] = {}
"""No plan names its place."""
SPARED, WAITING, UNDER_ATTACK, ATTACKED = 0, 1, 2, 3
NEVER = int(np.iinfo(np.int32).max)


@dataclass(frozen=True)
class Clock:
    """Steps and simulated time: step k ends at origin_s + k·step_s."""

    step_s: float
    origin_s: float = 0.0

    def step_at(self, time_s: float) -> int:
        """Return the first step that ends at `time_s` or later."""
        # The slack keeps 0.3 / 0.1 from being the fourth step.
        return ceil((time_s - self.origin_s) / self.step_s - 1e-6)


class Schedule(NamedTuple):
    """What one plan has in store for the vehicles; N vehicle rows.

    Attributes:
        state: (N,) SPARED, WAITING, UNDER_ATTACK or ATTACKED.
        start_step: (N,) first step of the attack; in a zone, the first at which it may begin until it has begun.
        end_step: (N,) first step after the attack; while it lasts, that at which it ends at the latest.
        inside_step: (N,) last step in which it was seen in the zone; -1 before, and without a zone.
        hold_steps: (N,) steps that an attack lasts after that.
    """

    state: Ints = blank(SPARED)
    start_step: Ints = blank(NEVER)
    end_step: Ints = blank(NEVER)
    inside_step: Ints = blank(-1)
    hold_steps: Ints = blank(0)


@dataclass(frozen=True, eq=False)
class Plan:
    """An attack plan at work: who is attacked, when, and the attack itself.

    Attributes:
        config: what the user said.
        zone: where vehicles are attacked; None for a plan that draws a window for each.
    """

    config: PlanConfig
    zone: Zone | None = None

    @property
    def name(self) -> str:
        """Name of the plan."""
        return self.config.name

    @property
    def attack(self) -> Attack:
        """The attack with its parameters."""
        return self.config.parameters

    def aims_at(self, vehicle_type: str, vehicle_id: str) -> bool:
        """Return whether the vehicle of that type, and that id in SUMO, may be attacked."""
        if self.config.vehicle_types and vehicle_type not in self.config.vehicle_types:
            return False
        return not self.config.vehicles or any(fnmatchcase(vehicle_id, meant) for meant in self.config.vehicles)

    def select(self, keys: Keys, type_ok: Flags) -> Flags:
        """Return (n,) whether the vehicles are attacked: of the right type, and drawn by the share."""
        drawn: Flags = noise.uniforms(keys, noise.PLAN_SHARE, 0) < self.config.share
        return drawn & type_ok

    def enter(
        self, schedule: Schedule, rows: Ints, keys: Keys, type_ok: Flags, settled_step: int, clock: Clock
    ) -> None:
        """Decide for vehicles at their departure.

        Args:
            schedule: of this plan; overwritten at `rows`.
            rows: (n,) vehicle rows that departed.
            keys: (n,) their keys; the share and the window are drawn from these alone.
            type_ok: (n,) whether the plan aims at their type.
            settled_step: first step in which they count as settled.
            clock: of the run.
        """
        config = self.config
        earliest = max(settled_step, clock.step_at(config.begin_s))
        latest = NEVER if config.end_s is None else clock.step_at(config.end_s)
        start = np.full(len(rows), earliest, np.int64)
        end = np.full(len(rows), latest, np.int64)
        if self.zone is None:
            start += _draw_steps(keys, noise.PLAN_START, config.start_after_s, clock)
            lasting = np.maximum(_draw_steps(keys, noise.PLAN_DURATION, config.duration_s, clock), 1)
            end = np.minimum(start + lasting, latest)
        chosen = self.select(keys, type_ok) & (start < end)
        schedule.state[rows] = np.where(chosen, WAITING, SPARED)
        schedule.start_step[rows] = np.where(chosen, np.minimum(start, NEVER), NEVER)
        schedule.end_step[rows] = np.where(chosen, np.minimum(end, NEVER), NEVER)
        if self.zone is not None:
            schedule.inside_step[rows] = -1
            schedule.hold_steps[rows] = ceil(self.zone.hold_s / clock.step_s - 1e-6)

    def advance(
        self,
        schedule: Schedule,
        rows: Ints,
        position_m: Floats,
        step: int,
        spoofers_m: Mapping[str, Floats] = NOBODY,
    ) -> tuple[Ints, Ints]:
        """Move on to `step`.

        A vehicle is under attack in the steps start_step … end_step - 1; it is attacked at most once.

        Args:
            schedule: of this plan; updated at `rows`.
            rows: (n,) vehicle rows on the road.
            position_m: (N, 2) of all vehicle rows, for zones.
            step: number of the step.
            spoofers_m: name of a plan -> (n, 2) where those are that carry its spoofer.

        Returns:
            Vehicle rows whose attack begins in this step, and those for which this is the first step after it.
        """
        state = schedule.state[rows]
        active = state == UNDER_ATTACK
        over = active & (schedule.end_step[rows] <= step)
        due = (state == WAITING) & (schedule.start_step[rows] <= step) & (step < schedule.end_step[rows])
        if self.zone is not None:
            asked = due | active
            inside = np.zeros(len(rows), np.bool_)
            inside[asked] = self.zone.contains(position_m[rows[asked]], spoofers_m)
            due &= inside
            schedule.inside_step[rows[inside]] = step
            over |= active & (step - schedule.inside_step[rows] > schedule.hold_steps[rows])
        starting, ending = rows[due], rows[over]
        schedule.state[starting] = UNDER_ATTACK
        schedule.start_step[starting] = step
        schedule.state[ending] = ATTACKED
        schedule.end_step[ending] = step
        return starting, ending

    def due_step(self, schedule: Schedule, rows: Ints) -> int:
        """Return the first step in which `advance` may find that an attack on `rows` begins or ends."""
        if self.zone is not None:
            return 0
        state = schedule.state[rows]
        starts, ends = schedule.start_step[rows[state == WAITING]], schedule.end_step[rows[state == UNDER_ATTACK]]
        return int(min(starts.min(initial=NEVER), ends.min(initial=NEVER)))


def _draw_steps(keys: Keys, channel: int, window_s: tuple[float, float], clock: Clock) -> np.ndarray:
    least, most = window_s
    seconds = least + (most - least) * noise.uniforms(keys, channel, 0)
    return np.floor(seconds / clock.step_s + 0.5).astype(np.int64)


def needed_memory_s(plans: Sequence[Plan]) -> float:
    """Return how far back the plans look at honest fixes."""
    return max((plan.attack.needed_memory_s() for plan in plans), default=0.0)


def build_plans(
    configs: Sequence[PlanConfig],
    drawn: Sequence[tuple[PlanConfig, Zone, str]] = (),
    carried: Sequence[tuple[PlanConfig, Zone | None, str]] = (),
    placed: Mapping[str, Zone] = NOWHERE,
    *,
    config_file: str = "gpsec.toml",
) -> list[Plan]:
    """Return the plans of a run: those of the configuration, of drawn zones, then those that vehicles carry.

    Args:
        configs: of the configuration; one that has a zone takes the area of the drawn zone of that id.
        drawn: as `plans_from_zones` gives them.
        carried: as `plans_from_vehicles` gives them.
        placed: the zones of plans of the configuration that name their place, by the plan's name.
        config_file: that `configs` come from, for error messages.

    Raises:
        GpsecError: a zone is unknown, or two plans have the same name.
    """
    zones = {zone.zone_id: zone for _, zone, _ in drawn} | {zone.zone_id: zone for _, zone, _ in carried if zone}
    plans: dict[str, Plan] = {}
    for i, config in enumerate(configs):
        where = f"{config_file}: plans[{i}]"
        zone = placed.get(config.name) if config.zone is None else _find(config.zone, zones, where)
        _add(plans, Plan(config, zone), where)
    for config, area, where in (*drawn, *carried):
        _add(plans, Plan(config, area), where)
    return list(plans.values())


def _find(zone_id: str, zones: Mapping[str, Zone], where: str) -> Zone:
    if zone_id not in zones:
        known = nearest(zone_id, zones) if zones else "no zone is drawn"
        raise GpsecError(f"{where}: zone: expected the id of a drawn zone, found '{shown(zone_id)}': {known}")
    return zones[zone_id]


def _add(plans: dict[str, Plan], plan: Plan, where: str) -> None:
    if plan.name in plans:
        raise GpsecError(f"{where}: name: expected a name that no other plan has, found '{shown(plan.name)}'")
    plans[plan.name] = plan
