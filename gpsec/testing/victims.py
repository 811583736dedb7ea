"""Victims made by hand, and a small loop that drives an attack."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from gpsec.attacks.base import Attack, Spoofed, Victims
from gpsec.attacks.knowledge import new_history, past_fixes, record_fixes
from gpsec.attacks.probing import Probed, asks_nobody
from gpsec.core.arrays import Flags, Floats
from gpsec.core.noise import vehicle_key
from gpsec.testing.contract import STEP_S, BrokenContractError, require

PastFix = Callable[[float], tuple[Floats, Flags]]


def no_past(delay_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Refuse to look back.

    Raises:
        BrokenContractError: always.
    """
    raise BrokenContractError("an attack without `needed_memory_s` does not ask for `past_fix`")


def by_distance(moved_m: Floats) -> Probed:
    """Answer as a detector whose statistic is the displacement, and whose threshold is a metre."""
    ratio = np.abs(moved_m).max(axis=2)
    return Probed(ratio, np.ones(ratio.shape, np.bool_))


def make_victims(m: int = 1, **given: object) -> Victims:
    """Return m victims on eastbound lanes; keyword arguments replace fields."""
    fields: dict[str, object] = {
        "rows": np.arange(m, dtype=np.int32),
        "key": np.array([vehicle_key(1, f"v{i}") for i in range(m)], np.uint64),
        "step": 0,
        "step_s": STEP_S,
        "elapsed_s": np.zeros(m),
        "fix_m": np.zeros((m, 2)),
        "fix_valid": np.ones(m, np.bool_),
        "lane_yaw_rad": np.zeros(m),
        "lane_width_m": np.full(m, 3.2),
        "left_lane": np.zeros(m, np.bool_),
        "right_lane": np.zeros(m, np.bool_),
        "blind": np.zeros(m, np.bool_),
        "deviation_m": np.zeros(m),
        "past_fix": no_past,
        "probe": by_distance,
    }
    return Victims(**{**fields, **given})  # type: ignore[arg-type]


def displacement(attack: Attack, victims: Victims) -> np.ndarray:
    """Return (m, 2) spoofed minus honest fix in the first step of an attack."""
    state = attack.new_state(int(victims.rows.max()) + 1).now
    return attack.apply(victims, state).fix_m - victims.fix_m


@dataclass(frozen=True)
class Surroundings:
    """Everything that victims see in T steps; (T, m, …) arrays."""

    fix_m: np.ndarray
    fix_valid: np.ndarray
    lane_yaw_rad: np.ndarray
    lane_width_m: np.ndarray
    left_lane: np.ndarray
    right_lane: np.ndarray
    blind: np.ndarray
    deviation_m: np.ndarray
    key: np.ndarray
    began: np.ndarray

    @classmethod
    def random(cls, steps: int = 60, m: int = 7) -> "Surroundings":
        """Return random lanes, gaps in the fixes, and attacks that began 0 to 3 s before step 40."""
        rng = np.random.default_rng(5)
        return cls(
            fix_m=rng.normal(0.0, 500.0, (steps, m, 2)),
            fix_valid=rng.random((steps, m)) < 0.8,
            lane_yaw_rad=rng.uniform(-np.pi, np.pi, (steps, m)),
            lane_width_m=rng.uniform(2.7, 3.8, (steps, m)),
            left_lane=rng.random((steps, m)) < 0.5,
            right_lane=rng.random((steps, m)) < 0.5,
            deviation_m=rng.normal(0.0, 0.4, (steps, m)),
            key=np.array([vehicle_key(9, f"w{i}") for i in range(m)], np.uint64),
            began=rng.integers(10, 40, m),
            blind=rng.random((steps, m)) < 0.3,
        )

    def take(self, order: np.ndarray) -> "Surroundings":
        """Return the victims `order` only, in that order."""
        step_first = {name: value[:, order] for name, value in vars(self).items() if value.ndim > 1}
        return replace(self, key=self.key[order], began=self.began[order], **step_first)

    def change_from(self, step: int) -> "Surroundings":
        """Return the same up to `step`, and everything else from there on."""
        other = {
            name: np.concatenate([value[:step], ~value[step:] if value.dtype == np.bool_ else value[step:] * 1.01])
            for name, value in vars(self).items()
            if value.ndim > 1
        }
        return replace(self, **other)


def drive(
    attack: Attack,
    world: Surroundings,
    rows: np.ndarray | None = None,
    watch: Callable[[float], None] = lambda delay_s: None,
) -> list[tuple[np.ndarray, Spoofed]]:
    """Run the attack; return (victims, their spoofed fixes) of every step.

    Vehicle rows are 0, 1, …, track rows `rows`; `watch` is told how far back each look at past fixes goes.

    Raises:
        BrokenContractError: the attack looks back further than it says.
    """
    steps, m = world.fix_valid.shape
    rows = np.arange(m, dtype=np.int32) if rows is None else rows
    state = attack.new_state(int(rows.max()) + 1).now
    history = new_history(m, attack.needed_memory_s(), STEP_S).now
    result = []
    for step in range(steps):
        record_fixes(np.arange(m, dtype=np.int32), step, world.fix_m[step], world.fix_valid[step], history)
        on = np.flatnonzero(world.began <= step)
        read = past_fixes(history, on.astype(np.int32), step, STEP_S)

        def past_fix(delay_s: float, read: PastFix = read) -> tuple[Floats, Flags]:
            watch(delay_s)
            furthest = attack.needed_memory_s()
            require(0.0 <= delay_s <= furthest, "`past_fix` is asked for no more than `needed_memory_s`")
            return read(delay_s)

        victims = Victims(
            rows=rows[on],
            key=world.key[on],
            step=step,
            step_s=STEP_S,
            elapsed_s=(step - world.began[on]) * STEP_S,
            fix_m=world.fix_m[step, on],
            fix_valid=world.fix_valid[step, on],
            lane_yaw_rad=world.lane_yaw_rad[step, on],
            lane_width_m=world.lane_width_m[step, on],
            left_lane=world.left_lane[step, on],
            right_lane=world.right_lane[step, on],
            blind=world.blind[step, on],
            deviation_m=world.deviation_m[step, on],
            past_fix=past_fix,
            probe=asks_nobody if attack.known() is None else by_distance,
        )
        result.append((on, attack.apply(victims, state)))
    return result
