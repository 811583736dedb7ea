"""How long a sweep takes on more cores than there are: its measured task times, dealt out by a simulated schedule.

``python -m benchmarks.schedule results/sweep --tasks 10000 --cores 2 64`` deals out so many tasks, drawn from those
that the sweep has done, as workers do it: whoever is free takes the next. Nothing is extrapolated but their number.
"""

import argparse
import heapq
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from gpsec.sweeps.folder import read_folder
from gpsec.types.constants import MANIFEST

_SEED = 2026


def makespan_s(times_s: Sequence[float], workers: int, overhead_s: float, dispatch_s: float) -> float:
    """Return when the last of the tasks ends.

    Args:
        times_s: of the tasks, in their order.
        workers: each runs one at a time.
        overhead_s: of each task on its worker.
        dispatch_s: of each task at the one who deals them out, one after the other.
    """
    free_s = [0.0] * workers
    dealt_s = 0.0
    for time_s in times_s:
        dealt_s += dispatch_s
        begin_s = max(heapq.heappop(free_s), dealt_s)
        heapq.heappush(free_s, begin_s + overhead_s + time_s)
    return max(free_s)


def measured(folder: Path) -> tuple[list[float], list[int]]:
    """Return the seconds that each run took, and its bytes in the store."""
    sweep = read_folder(folder)
    times_s, sizes = [], []
    for fingerprint in sweep.labels:
        if sweep.store.has(fingerprint):
            place = sweep.store.result(fingerprint)
            times_s.append(float(json.loads((place / MANIFEST).read_text("utf-8"))["total_s"]))
            sizes.append(sum(path.stat().st_size for path in place.iterdir()))
    return times_s, sizes


def main() -> None:
    """Print hours and use of the cores for each number of cores."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.schedule", description=__doc__)
    parser.add_argument("folder", type=Path, help="of a sweep, some of whose runs are done")
    parser.add_argument("--tasks", type=int, default=10_000, metavar="N", help="how many are dealt out")
    parser.add_argument("--cores", type=int, nargs="+", default=[2, 16, 64, 256, 1024, 4096], metavar="N")
    parser.add_argument("--overhead-s", type=float, default=2.0, help="start of the processes of a run")
    parser.add_argument("--dispatch-ms", type=float, default=10.0, help="see sweep_dask_task_ms of the benchmark")
    options = parser.parse_args()
    times_s, sizes = measured(options.folder)
    drawn = np.random.default_rng(_SEED).choice(times_s, options.tasks)
    table = Table("cores", "hours", "of the cores in use", "waiting for who deals out")
    for cores in options.cores:
        whole_s = makespan_s(drawn.tolist(), cores, options.overhead_s, options.dispatch_ms / 1000.0)
        ideal_s = makespan_s(drawn.tolist(), cores, options.overhead_s, 0.0)
        use = float(drawn.sum()) / (whole_s * cores)
        table.add_row(str(cores), f"{whole_s / 3600.0:.3g}", f"{use:.0%}", f"{(whole_s - ideal_s) / 3600.0:.2g} h")
    console = Console()
    console.print(
        f"{len(times_s)} runs measured: median {np.median(times_s):.3g} s, longest {max(times_s):.3g} s, "
        f"{np.mean(sizes) / 1e6:.3g} MB; {options.tasks} of them: {drawn.sum() / 3600.0:.4g} core hours, "
        f"{options.tasks * np.mean(sizes) / 1e9:.3g} GB",
        highlight=False,
    )
    console.print(table)


if __name__ == "__main__":
    main()
