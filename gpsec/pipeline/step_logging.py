"""Logs the steps of a run: of all vehicles, or of those that the scenario names."""

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from gpsec.hdmap.map import HDMap
from gpsec.outcomes.steps import StepLog
from gpsec.outcomes.study import Study
from gpsec.outcomes.view import StepView
from gpsec.pipeline.loop import Loop


def open_step_log(path: Path, study: Study, hd_map: HDMap) -> StepLog:
    """Return a new log of steps at `path`."""
    return StepLog(path, study.plans, study.detectors, study.defences, hd_map.lane_ids, hd_map.projector)


class StepLogger:
    """Writes the steps of a run into a log as it goes on.

    Args:
        log: where to.
        chosen: ids of SUMO, or of rows such as ``id#2``, of the vehicles that are logged; empty: all.
    """

    def __init__(self, log: StepLog, chosen: Collection[str]) -> None:
        self._log = log
        self._chosen = set(chosen)
        self._logged: set[str] = set()

    def observe(self, view: StepView, loop: Loop) -> None:
        """Log the tracks of a step that the loop has taken."""
        people = [loop.fleet[row] for row in loop.tracks.vehicle[view.rows].tolist()]
        if self._chosen:
            kept = [place for place, who in enumerate(people) if {who.vehicle_id, who.sumo_id} & self._chosen]
            view, people = replace(view, rows=view.rows[kept]), [people[place] for place in kept]
            self._logged.update(name for who in people for name in (who.vehicle_id, who.sumo_id))
        self._log.observe(view, [who.vehicle_id for who in people], loop.seen)

    def absent(self) -> list[str]:
        """Return those of the chosen vehicles of which no step was logged."""
        return sorted(self._chosen - self._logged)

    def close(self) -> None:
        """Write what is left and close the log."""
        self._log.close()
