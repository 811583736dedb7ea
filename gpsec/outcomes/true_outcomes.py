"""What truly happened to the vehicles of a closed loop, and to the whole world: sums of every step."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import Table, blank
from gpsec.outcomes.state import OUTCOMES, worst

# SUMO's drivers use their 4.5 m/s² whenever they brake; what is beyond is an emergency. Slower vehicles stand.
HARD_MPS2, STANDING_MPS = 6.0, 0.1


class TrueStory(NamedTuple):
    """What is remembered of each vehicle; N vehicle rows.

    Attributes:
        attacked: (N,) it has been under attack.
        start_step: (N,) the first such step, -1 for none.
        first_step: (N, 4) first step of each outcome since, -1 for none.
        displaced_m: (N,) largest displacement since.
        crash_step, crash_kind: (N,) of the first hit, -1 for none.
        stood_steps: (N,) steps since the attack began in which it stood.
        released_step: (N,) step in which it was SUMO's again, -1 for none.
        speed_mps: (N,) in the last step; hard: (N,) it braked hard then; calm: (N,) no alarm then.
        stopping: (N,) braked on an alarm in the last step; driver: (N,) was in a driver's hands.
    """

    attacked: Flags = blank(False)
    start_step: Ints = blank(-1)
    first_step: Ints = blank(-1, 4)
    displaced_m: Floats = blank(0.0)
    crash_step: Ints = blank(-1)
    crash_kind: Ints = blank(-1)
    stood_steps: Ints = blank(0)
    released_step: Ints = blank(-1)
    speed_mps: Floats = blank(-1.0)
    hard: Flags = blank(False)
    calm: Flags = blank(True)
    stopping: Flags = blank(False)
    driver: Flags = blank(False)


@dataclass(frozen=True)
class TrueStep:
    """A step of the fleet as it truly was; n vehicles.

    Attributes:
        rows: (n,) vehicle rows.
        attacked, alarm: (n,) under attack; in alarm by the acting defence.
        speed_mps: (n,).
        offset_m: (n,) displacement, left positive; 0 where SUMO steers.
        reached: (n, 4) outcomes, see `gpsec.outcomes.displaced`.
        stopping, driver: (n,) brakes on an alarm; steers by camera or driver on one.
        released: rows that are SUMO's again.
    """

    rows: Ints
    attacked: Flags
    alarm: Flags
    speed_mps: Floats
    offset_m: Floats
    reached: Flags
    stopping: Flags
    driver: Flags
    released: Ints


@dataclass
class WorldTotals:
    """Sums over a world, in the order of the columns of `worlds.csv`."""

    vehicles: int = 0
    attacked: int = 0
    vehicle_km: float = 0.0
    arrived: int = 0
    steps: int = 0
    standing_steps: int = 0
    wrong_way_steps: int = 0
    hard_brakings: int = 0
    alarms: int = 0
    stops: int = 0
    handovers: int = 0
    reached: np.ndarray = field(default_factory=lambda: np.zeros(4, np.int64))


class TrueOutcomes:
    """What truly happens to a fleet.

    Attributes:
        totals: sums so far; those of attacked vehicles are complete once these have left.
        stories: of the attacked vehicles that have left, a mapping each.
    """

    def __init__(self, step_s: float, origin_s: float) -> None:
        self.totals = WorldTotals()
        self.stories: list[dict[str, Any]] = []
        self._step_s, self._origin_s = step_s, origin_s
        self._table = Table(TrueStory)

    def enter(self, rows: Ints) -> None:
        """Begin anew in `rows`."""
        self._table.grow(2 * (int(rows.max(initial=0)) + 1))
        self._table.reset(rows)
        self.totals.vehicles += len(rows)

    def add(self, step: int, now: TrueStep) -> None:
        """Add a step."""
        rows, story, totals = now.rows, self._table.now, self.totals
        self._add_totals(now)
        new = rows[now.attacked & ~story.attacked[rows]]
        story.attacked[new] = True
        story.start_step[new] = step
        hit = story.attacked[rows]
        mine = rows[hit]
        first = story.first_step[mine]
        story.first_step[mine] = np.where((first < 0) & now.reached[hit], step, first)
        story.displaced_m[mine] = np.maximum(story.displaced_m[mine], np.abs(now.offset_m[hit]))
        story.stood_steps[mine] += now.speed_mps[hit] < STANDING_MPS
        back = now.released[story.attacked[now.released]]
        story.released_step[back] = step
        totals.attacked += len(new)

    def _add_totals(self, now: TrueStep) -> None:
        rows, story, totals = now.rows, self._table.now, self.totals
        before = story.speed_mps[rows]
        hard = (before >= 0.0) & (before - now.speed_mps > HARD_MPS2 * self._step_s)
        totals.steps += len(rows)
        totals.vehicle_km += float(now.speed_mps.sum()) * self._step_s / 1000.0
        totals.standing_steps += int((now.speed_mps < STANDING_MPS).sum())
        totals.wrong_way_steps += int(now.reached[:, 2].sum())
        totals.hard_brakings += int((hard & ~story.hard[rows]).sum())
        totals.alarms += int((now.alarm & story.calm[rows]).sum())
        totals.stops += int((now.stopping & ~story.stopping[rows]).sum())
        totals.handovers += int((now.driver & ~story.driver[rows]).sum())
        story.speed_mps[rows], story.hard[rows] = now.speed_mps, hard
        story.calm[rows], story.stopping[rows], story.driver[rows] = ~now.alarm, now.stopping, now.driver

    def was_attacked(self, row: int) -> bool:
        """Return whether a vehicle is or has been under attack."""
        return bool(self._table.now.attacked[row])

    def crash(self, step: int, row: int, kind: int) -> None:
        """Note a hit of a vehicle; the first one counts."""
        story = self._table.now
        if story.crash_step[row] < 0:
            story.crash_step[row], story.crash_kind[row] = step, kind

    def close(self, people: Mapping[int, str], kinds: Mapping[int, str]) -> None:
        """Keep the stories of the rows of `people` (row -> vehicle id), who leave; `kinds` names the crashes."""
        story = self._table.now
        for row, name in people.items():
            if not story.attacked[row]:
                continue
            outcome, outcome_step = worst(story.first_step[row : row + 1])
            self.totals.reached += story.first_step[row] >= 0
            start = int(story.start_step[row])
            self.stories.append(
                {
                    "vehicle_id": name,
                    "displaced_max_m": float(story.displaced_m[row]),
                    "true_outcome": ["none", *OUTCOMES][int(outcome[0]) + 1],
                    "true_outcome_s": self._after(int(outcome_step[0]), start),
                    "crash_s": self._after(int(story.crash_step[row]), start),
                    "crash_kind": kinds.get(int(story.crash_kind[row]), ""),
                    "stood_s": float(story.stood_steps[row] * self._step_s),
                    "released_s": self._after(int(story.released_step[row]), start),
                }
            )

    def _after(self, step: int, start: int) -> float:
        """Return the seconds from the beginning of the attack to a step, NaN where there is none."""
        return (step - start) * self._step_s if step >= 0 else float("nan")
