"""What attackers send: each track under attack gets the fix that its plan's attack makes of the honest one."""

from collections.abc import Sequence

import numpy as np

from gpsec.attacks.base import Victims
from gpsec.attacks.knowledge import new_history, past_fixes, record_fixes
from gpsec.attacks.probing import Probe, Probed, Probes, Question, asks_nobody
from gpsec.attacks.schedule import Plan, needed_memory_s
from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.pipeline.loop_settings import LoopSettings
from gpsec.pipeline.perception import StepInputs
from gpsec.types.method import Method
from gpsec.types.vehicles import Measurements, Vehicles


class Spoofing:
    """The attackers of a run at work.

    Attributes:
        history: honest fixes of vehicle rows, as far back as the plans look.
    """

    def __init__(self, settings: LoopSettings, plans: Sequence[Plan], method: Method) -> None:
        """Begin with nobody under attack; attackers who know detectors ask those of `method`."""
        self._plans, self._method = plans, method
        self._step_s, self._map, self._targets = settings.step_s, settings.hd_map, settings.targets
        self._states = [plan.attack.new_state(1) for plan in plans]
        self.history = new_history(1, needed_memory_s(plans), settings.step_s)

    def grow(self, capacity: int) -> None:
        """Make room for `capacity` track rows."""
        for state in self._states:
            state.grow(capacity)

    def begin(self, number: int, rows: Ints) -> None:
        """Let attacks of plan `number`, from 1, begin on (n,) track rows."""
        self._states[number - 1].reset(rows)

    def note_fixes(self, rows: Ints, step: int, seen: Measurements) -> None:
        """Remember the honest fixes of (n,) vehicle rows."""
        record_fixes(rows, step, seen.fix_m, seen.fix_valid, self.history.now)

    def spoof(self, rows: Ints, inputs: StepInputs) -> None:
        """Give (n,) track rows the fixes of this step: the honest ones, and to those under attack false ones."""
        step, tracks, vehicles, seen, _ = inputs
        tracks.fix_m[rows] = seen.fix_m[tracks.vehicle[rows]]
        tracks.fix_valid[rows] = seen.fix_valid[tracks.vehicle[rows]]
        attacked = rows[tracks.attacked[rows]]
        plan_of, left, right = tracks.plan[attacked], *self._lanes_beside(tracks.vehicle[attacked], vehicles)
        for number in sorted(set(plan_of.tolist())):
            plan, of_it = self._plans[number - 1], plan_of == number
            chosen = attacked[of_it]
            vehicle = tracks.vehicle[chosen]
            victims = Victims(
                rows=chosen,
                key=vehicles.key[vehicle],
                step=step,
                step_s=self._step_s,
                elapsed_s=(step - tracks.start_step[chosen]) * self._step_s,
                fix_m=seen.fix_m[vehicle],
                fix_valid=seen.fix_valid[vehicle],
                lane_yaw_rad=vehicles.lane_yaw_rad[vehicle],
                lane_width_m=vehicles.lane_width_m[vehicle],
                left_lane=left[of_it],
                right_lane=right[of_it],
                blind=~vehicles.marked[vehicle],
                deviation_m=tracks.deviation_m[chosen],
                past_fix=past_fixes(self.history.now, vehicle, step, self._step_s),
                probe=self._probe(plan, chosen, inputs),
            )
            spoofed = plan.attack.apply(victims, self._states[number - 1].now)
            tracks.fix_m[chosen] = spoofed.fix_m
            tracks.fix_valid[chosen] = spoofed.valid

    def _probe(self, plan: Plan, rows: Ints, inputs: StepInputs) -> Probe:
        """Return what answers an attacker of the track rows `rows` who knows detectors."""
        known, method = plan.attack.known(), self._method
        if known is None or not isinstance(method, Probes):
            return asks_nobody
        columns = self._targets[plan.name]

        def probe(moved_m: Floats) -> Probed:
            return method.probe(inputs.number, Question(rows, moved_m, columns, known.own_copy), *inputs[1:])

        return probe

    def _lanes_beside(self, vehicle: Ints, vehicles: Vehicles) -> tuple[Flags, Flags]:
        """Return whether (n,) vehicle rows have a lane of either direction to their left, and to their right."""
        lane, against = vehicles.lane[vehicle], vehicles.against[vehicle]
        left, right = self._map.beside(lane, left=True), self._map.beside(lane, left=False)
        return np.where(against, right, left), np.where(against, left, right)
