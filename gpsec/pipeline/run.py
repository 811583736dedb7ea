"""The one loop: traffic, truth, sensors, attacks, residual, detectors, filters, outcomes."""

from collections.abc import Collection, Iterator
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from gpsec.attacks.plans import NO_ATTACK
from gpsec.core.errors import GpsecError, shown
from gpsec.core.kernels import import_compiler
from gpsec.core.progress import Progress, Report
from gpsec.core.stopwatch import Stopwatch
from gpsec.core.threads import Threads
from gpsec.detection.base import Detection
from gpsec.outcomes.kept_traces import KeptTraces
from gpsec.outcomes.lanes import honest_shares
from gpsec.outcomes.recorder import Outcomes
from gpsec.outcomes.study import Study
from gpsec.outcomes.tables import STEP_LOG, TRACES
from gpsec.outcomes.view import StepView
from gpsec.pipeline.build import (
    Ground,
    drawn_zones,
    lay_ground,
    loop_settings,
    make_detection,
    make_method,
    make_plans,
)
from gpsec.pipeline.closed_loop import Acting, ClosedLoop, blind_off_the_lane
from gpsec.pipeline.fleet_choice import Few
from gpsec.pipeline.interfaces import Onlooker, StartTraffic, Traffic
from gpsec.pipeline.logged_run import LoggedRun
from gpsec.pipeline.loop import Loop
from gpsec.pipeline.manifest import Counts, write_manifest
from gpsec.pipeline.mapfile import write_map
from gpsec.pipeline.mismatch import make_shared_errors, mismatch_note
from gpsec.pipeline.probing import target_columns
from gpsec.pipeline.remarks import Remarks, beforehand
from gpsec.pipeline.step_logging import StepLogger, open_step_log
from gpsec.scenario import Scenario
from gpsec.scenario.worlds import can_steer
from gpsec.traffic.remote import RemoteSession
from gpsec.traffic.stderr import input_warnings


def run_scenario(
    scenario: Scenario,
    folder: Path,
    report: Report,
    start: StartTraffic | None = None,
    only: Collection[str] | None = None,
    onlooker: Onlooker | None = None,
    logged: LoggedRun | None = None,
    *,
    takes_commands: bool = False,
) -> None:
    """Run a scenario and write its tables and its manifest into `folder`, which exists.

    libsumo allows one simulation per process, and so this can run once at a time in a process. `start` puts other
    traffic, such as a recording, in the place of SUMO. `only` are the ids of vehicles of a former run that are looked
    at again: nobody else is part of the fleet then, and they do as they did. `onlooker` sees every step and
    changes nothing. `logged` is a log, whose traffic, bodies and sensors are taken. `takes_commands` says of what
    `start` starts that its vehicles can be steered.

    Raises:
        GpsecError: the scenario cannot be run, or nobody of the fleet departs.

    """
    began = perf_counter()
    report(Progress(scenario.name, stage="loading the net"))
    closed = scenario.closed_loop.world is not None
    if closed and ((start is not None and not takes_commands) or logged is not None):
        raise GpsecError(
            f"scenario '{scenario.name}': closed loop: expected SUMO, found a recording, which cannot react"
        )
    ground = lay_ground(scenario)
    if logged is not None and ground.pixels is not None:
        raise GpsecError(
            f"scenario '{scenario.name}': fleet.camera.source: expected 'profile' for a log, whose lanes are recorded,"
            " found 'image'"
        )
    if logged is not None:
        ground, start = logged.laid_on(ground), logged.start
    detection = make_detection(scenario, ground)
    with ExitStack() as stack:
        stack.enter_context(threadpool_limits(1))
        choice = ground.choice if only is None else Few.named(ground.choice, only)
        begin = start or partial(RemoteSession, controlled=closed)
        traffic = begin(ground.options, ground.hd_map.lane_index, choice.equipped)
        session = stack.enter_context(traffic)
        import_compiler()  # while SUMO loads its net
        _Run(scenario, folder, report, ground, detection, session, stack, onlooker).go(began)


class _Run:
    """One run, from the started simulation to the written files."""

    def __init__(
        self,
        scenario: Scenario,
        folder: Path,
        report: Report,
        ground: Ground,
        detection: Detection,
        session: Traffic,
        stack: ExitStack,
        onlooker: Onlooker | None,
    ) -> None:
        self.scenario = scenario
        self.folder = folder
        self.report = report
        self.ground = ground
        self.session = session
        self.threads = Threads(scenario.threads)
        stack.callback(self.threads.close)
        self.watch = Stopwatch()
        self.counts = Counts()
        self.remarks = Remarks(ground.hd_map)
        self.notes: list[str] = []
        self.first_s: float | None = None  # when somebody was on the road for the first time
        for note in (*ground.options.notes, *beforehand(ground), *mismatch_note(scenario), *ground.notes):
            self._say(note)
        zones = drawn_zones(session)
        plans = self.plans = make_plans(scenario, ground, session.options, zones)
        shared = make_shared_errors(scenario, ground.sensors, ground.hd_map, zones)
        self.places = () if shared is None else shared.places
        defences = [(defence.point, defence.response) for defence in scenario.defences]
        names = [NO_ATTACK, *(plan.name for plan in plans)]
        method = make_method(scenario, ground, detection, plans)
        study = Study(
            tuple(names),
            detection.names,
            detection.rates,
            detection.origins,
            tuple(defences),
            ground.choice.profiles,
            detection.thresholds,
            session.step_s,
            scenario.fleet.association,
        )
        # A log of all steps holds them too, and in closed loop nobody has a twin that shows what was before.
        traces = None if scenario.log_steps or scenario.closed_loop.world is not None else KeptTraces(study)
        hd_map = ground.hd_map
        self.outcomes = Outcomes(study, hd_map.roads(np.zeros(1, np.int32)), hd_map.lane_ids, traces)
        self.onlooker = onlooker
        if onlooker is not None:
            onlooker.begin(self.outcomes.study)
        self.logger = None
        if scenario.log_steps or scenario.log_vehicles:
            log = stack.enter_context(open_step_log(folder / STEP_LOG, study, ground.hd_map))
            self.logger = StepLogger(log, scenario.log_vehicles)
        self.method = method
        targets = target_columns(detection, plans)
        settings = loop_settings(scenario, ground, session.step_s, shared, targets)
        if scenario.closed_loop.world is not None:
            settings = replace(settings, look=blind_off_the_lane)
        self.loop = Loop(settings, plans, method, self.outcomes, self.threads, self.watch)
        self.closed_loop = self._closed_loop(study)

    def _closed_loop(self, study: Study) -> ClosedLoop | None:
        """Return what steers the vehicles, None in open loop."""
        scenario, world = self.scenario, self.scenario.closed_loop.world
        if world is None:
            return None
        number = [defence.name for defence in scenario.defences].index(world.defence)
        acting = Acting(number, int(study.detector_of[number]))
        profiles = self.ground.choice.profiles
        if left := [name for name in profiles if not can_steer(name)]:
            self._say(f"closed loop: vehicles with profile {', '.join(left)} are SUMO's: too inaccurate to steer by")
        return ClosedLoop(scenario, self.ground.hd_map, profiles, acting, self.session.step_s)

    def go(self, began: float) -> None:
        """Run to the end and write the files."""
        scenario, session, loop = self.scenario, self.session, self.loop
        duration_s = scenario.duration_s or self._configured_duration()
        loop_began = perf_counter()
        for frame in session.frames(scenario.duration_s):
            self.watch.start()
            self.remarks.before(frame, loop)
            if self.closed_loop is not None:
                self.closed_loop.leave(frame)
            loop.step(frame)
            self.remarks.after(frame, loop)
            if self.closed_loop is not None:
                session.command(self.closed_loop.step(frame, loop, self.method.answers))
                self.watch.lap("closed loop")
            self._observe(frame.step, frame.time_s)
            self.counts.add(frame, len(loop.track_rows), int(loop.vehicles.against[frame.rows].sum()))
            if self.first_s is None and frame.on_road:
                self.first_s = frame.time_s
            if frame.step % 10 == 0:
                elapsed_s = (frame.step + 1) * session.step_s
                self.report(
                    Progress(
                        scenario.name,
                        elapsed_s,
                        duration_s,
                        len(frame.rows),
                        len(loop.track_rows),
                        elapsed_s / max(perf_counter() - loop_began, 1e-9),
                    )
                )
        self.counts.loop_s = perf_counter() - loop_began
        self._check_not_empty()
        loop.finish()
        self.report(Progress(scenario.name, stage="writing tables"))
        for note in (*self._what_did_not_happen(), *self.remarks.sentences(self.counts, self.outcomes)):
            self._say(note, "writing tables")
        self.watch.start()
        if self.outcomes.traces is not None:
            with open_step_log(self.folder / TRACES, self.outcomes.study, self.ground.hd_map) as traces:
                self.outcomes.write_traces(traces)
        settings = scenario.outcomes
        self.outcomes.write(
            self.folder,
            scenario.name,
            scenario.seed,
            replicates=settings.bootstrap,
            confidence=settings.confidence,
            projector=self.ground.hd_map.projector,
        )
        if self.loop.eyes is not None:
            self.counts.pixels = self.loop.eyes.stated()
        if self.closed_loop is not None:
            self.counts.closed_loop = self.closed_loop.write(self.folder, self.ground.hd_map.projector)
        write_map(self.folder, self.ground.hd_map, self.plans, self.places)
        self.watch.lap("files")
        self.counts.sumo_s, self.counts.read_s = session.sumo_s, session.read_s
        self.counts.compile_s = self.watch.compile_s
        self.counts.right_lane_share = honest_shares(self.outcomes.study, self.outcomes.lanes)
        session.close()
        for note in input_warnings(session.warnings):
            self._say(note, "writing tables")
        if self.logger is not None:
            self.logger.close()
        self.counts.total_s = perf_counter() - began
        write_manifest(
            self.folder,
            scenario,
            self.ground,
            self.plans,
            self.counts,
            self.watch.stages_s,
            self.notes,
            session.warnings,
        )

    def _say(self, note: str, stage: str = "loading the net") -> None:
        self.notes.append(note)
        self.report(Progress(self.scenario.name, stage=stage, note=note))

    def _what_did_not_happen(self) -> Iterator[str]:
        begin_s, asked_s = self.ground.options.begin_s, self.scenario.duration_s
        if asked_s is not None and self.first_s is not None and self.first_s - begin_s > asked_s + self.session.step_s:
            yield (
                f"nobody departed in the first {asked_s:g} s; they count from the first departure, at"
                f" {self.first_s:g} s (traffic.begin_s = {self.first_s // 1:g} begins there)"
            )
        if others := self.session.traffic_only:
            said = ", ".join(f"{count} of class {name}" for name, count in sorted(others.items()))
            yield f"traffic only, never equipped: {said}"
        idle = [plan.name for plan, begun in zip(self.plans, self.loop.attacks, strict=True) if begun == 0]
        if idle:
            yield (
                f"no vehicle was attacked under {', '.join(idle)}: an attack begins when a vehicle has settled"
                f" ({self.scenario.fleet.settle_s:g} s) and its window has come, or in its zone"
            )
        if self.loop.eyes is not None and (absent := self.loop.eyes.absent()):
            yield f"no pictures of {shown(', '.join(absent))}: no such vehicle of the fleet in this run"
        if self.logger is not None and (absent := self.logger.absent()):
            yield f"no steps of {shown(', '.join(absent))}: no such vehicle in this run"

    def _observe(self, step: int, time_s: float) -> None:
        loop, answers = self.loop, self.method.answers
        view = StepView(
            step=step,
            step_s=self.session.step_s,
            time_s=time_s,
            rows=loop.track_rows,
            tracks=loop.tracks,
            vehicles=loop.vehicles,
            seen=loop.seen,
            answers=answers,
        )
        self.outcomes.observe(view, self.threads)
        self.watch.lap("outcomes")
        if self.onlooker is not None:
            self.onlooker.see(view, self.outcomes.state, loop.fleet)
            self.watch.lap("window")
        if self.logger is not None:
            self.logger.observe(view, loop)
            self.watch.lap("step log")

    def _configured_duration(self) -> float | None:
        end_s = self.ground.options.end_s
        return None if end_s is None else end_s - self.ground.options.begin_s

    def _check_not_empty(self) -> None:
        config = self.ground.options.config
        if self.counts.steps == 0 or self.counts.peak_on_road == 0:
            raise GpsecError(f"{config}: no vehicle departs within the time that is simulated")
        if self.counts.vehicles == 0:
            raise GpsecError(
                f"{config}: no vehicle is equipped, of up to {self.counts.peak_on_road} on the road at once;"
                f" expected a larger fleet.equipped_share (it is {self.scenario.fleet.equipped_share:g}) or"
                " gpsec.equipped of their types, a longer run, or vehicles of road classes"
            )
