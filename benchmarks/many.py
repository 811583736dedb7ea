"""What it costs to run many: two workers beside one, and what a list of a thousand tasks takes beside their work."""

import json
import os
import shutil
import sys
import time
from collections.abc import Collection, Iterator
from pathlib import Path

from benchmarks.bench import Bench
from benchmarks.city import ROOT
from benchmarks.figures import Figure, Round, Sample

SPEED_UP = Figure("sweep_speed_up", "a sweep of 8 runs: one worker bound to one core ÷ two at a time on two", 1.8, True)
TASK = Figure("sweep_task_ms", "a sweep of 1,000 tasks that do nothing: ms a task, local", 20.0)
DASK_TASK = Figure("sweep_dask_task_ms", "the same on a local cluster of Dask, with two workers", 20.0)
FIGURES = (SPEED_UP, TASK, DASK_TASK)
PLAN = """
[set]
duration_s = {duration_s}

[[entries]]
name = "all"
scenarios = ["{scenario}"]
seeds = "1-{seeds}"
"""


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of sweeps."""
    for _ in range(bench.runs):
        if SPEED_UP.key in wanted:
            yield _speed_up(bench)
        for figure, where in ((TASK, "here"), (DASK_TASK, "dask")):
            if figure.key in wanted:
                yield _nothing(bench, figure, where)


def _speed_up(bench: Bench) -> Round:
    plan = bench.work / "many.toml"
    scenario = ROOT / "scenarios" / "slow_curve"
    duration_s, seeds = (2.0, 2) if bench.quick else (60.0, 8)
    plan.write_text(PLAN.format(duration_s=duration_s, scenario=scenario, seeds=seeds))
    taken = {}
    for label, jobs, core in (("one worker", 1, "0"), ("two workers", 2, "0,1")):
        folder = bench.work / "many"
        shutil.rmtree(folder, ignore_errors=True)
        bench.measure("list", "gpsec", "sweep", str(plan), "--list", "--out", str(folder))
        bound = (shutil.which("taskset") or "/usr/bin/taskset", "-c", core, sys.executable, "-m", "gpsec")
        taken[label] = bench.measure(label, *bound, "sweep", "--worker", str(folder), "--jobs", str(jobs)).wall_s
    one, two = taken.values()
    return {SPEED_UP.key: Sample(one / two, {"one_s": one, "two_s": two})}


def _nothing(bench: Bench, figure: Figure, where: str) -> Round:
    answer, count = bench.work / "answer.json", 20 if bench.quick else 1000
    folder = bench.work / "nothing"
    shutil.rmtree(folder, ignore_errors=True)
    bench.measure(f"{count} tasks, {where}", "benchmarks.many", where, str(folder), str(count), str(answer))
    told = json.loads(answer.read_text())
    return {figure.key: Sample(told["ms"], told)}


def make_nothing(path: str, fingerprint: str, label: str, run: object, allow_code: bool = False) -> dict[str, object]:
    """Claim a task and publish a result of three bytes, as a worker does, in this process."""
    from gpsec.sweeps.desk import SweepDesk
    from gpsec.sweeps.on_worker import folder_of

    desk = SweepDesk(folder_of(path), [fingerprint], notes=False)
    task = desk.take()
    if task is not None:
        task.folder.mkdir()
        (task.folder / "manifest.json").write_text("{}\n")
        desk.settle(task, None)
    return {"state": "done", "sentence": "", "details": "", "machine": True, "worker": label}


def main(where: str, folder: str, count: str, answer: str) -> None:
    """Work through a list of tasks that do nothing; write ms a task and how the memory of this process grew."""
    from gpsec.core.progress import Progress
    from gpsec.scenario import load_scenario
    from gpsec.sweeps.folder import write_list
    from gpsec.sweeps.points import ListedTask, Point

    told = load_scenario(ROOT / "scenarios" / "town").model_dump_json()
    tasks = (
        ListedTask(
            fingerprint=f"{number:064d}",
            label=f"task {number}",
            point=Point(entry="all", scenario="town", seed=number),
            told=told,
        )
        for number in range(int(count))
    )
    sweep = write_list(Path(folder), tasks, {}, None)
    memory = [_memory_mb()]

    def report(progress: Progress) -> None:
        memory.append(_memory_mb())

    if where == "here":
        began = time.perf_counter()
        for fingerprint, label in sweep.labels.items():
            make_nothing(folder, fingerprint, label, None)
            report(Progress(label))
        taken_s = time.perf_counter() - began
    else:
        from gpsec.sweeps import on_dask

        setattr(on_dask, "run_one", make_nothing)  # noqa: B010
        with on_dask.connected("local", 2) as client:
            began = time.perf_counter()
            on_dask.work_on(client, sweep, list(sweep.labels), report)
            taken_s = time.perf_counter() - began
    grown_mb = memory[-1] - memory[len(memory) // 5]
    stated = {"ms": 1000.0 * taken_s / int(count), "client_mb": memory[-1], "client_grown_mb": grown_mb}
    Path(answer).write_text(json.dumps(stated))


def _memory_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


if __name__ == "__main__":
    main(*sys.argv[1:])
