"""A long run, watched from outside: ``python -m benchmarks.soak --help``.

Ten million vehicle-steps show what a short run hides: memory that grows, files that stay open, shared memory that is
not given back, a number that stopped being one. Plain SUMO with the same traffic tells whose memory it is.
"""

import argparse
import json
import signal
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console
from rich.table import Table

from benchmarks.bench import SCENARIOS
from benchmarks.city import CITY, ROOT, SMALL_CITY, SUMO, City, build
from benchmarks.processes import RunFailedError
from benchmarks.watch import Watched, watch

VEHICLE_STEPS, QUICK_VEHICLE_STEPS = 10_000_000, 20_000
# Vehicles at once, by which the duration is chosen; those that there were are in the manifest.
AT_ONCE = {CITY.name: 2_400, SMALL_CITY.name: 150}
STEPS_PER_S = 10
SHARED_MEMORY = Path("/dev/shm")
# The evaluator may not grow by more over the second half of the run.
GROWTH_MB = 20.0
# In a shorter run the start is in the second half, too.
SETTLED_S = 60.0
NO_NUMBERS = ("nan", "inf", "+inf", "-inf", "infinity", "+infinity", "-infinity")
INTERRUPTED = 130


def main(arguments: list[str] | None = None) -> int:
    """Run and watch; return 1 where something was found or the run failed, else 0."""
    options = _parser().parse_args(arguments)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends what is running, too
    console = Console(emoji=False)
    city = SMALL_CITY if options.quick else CITY
    wanted = QUICK_VEHICLE_STEPS if options.quick else options.vehicle_steps
    with console.status(f"building {city.name}, once"):
        build(city)
    try:
        told, processes = soak(city, round(wanted / AT_ONCE[city.name] / STEPS_PER_S, 1), console)
    except RunFailedError as error:
        console.print(f"failed: {error}", markup=False, highlight=False, style="red", soft_wrap=True)
        return 1
    except KeyboardInterrupt:
        console.print("interrupted")
        return INTERRUPTED
    options.out.parent.mkdir(parents=True, exist_ok=True)
    courses = {role: {**watched.figures(), **asdict(watched)} for role, watched in processes.items()}
    options.out.write_text(json.dumps({**told, "processes": courses}, indent=1))
    console.print(_table(processes, f"{told['vehicle_steps']:,} vehicle-steps of {told['vehicles']:,} vehicles"))
    for sentence in told["found"]:
        console.print(sentence, style="red", highlight=False, soft_wrap=True)
    console.print(f"written to {options.out}", highlight=False)
    return 1 if told["found"] else 0


def soak(city: City, duration_s: float, console: Console) -> tuple[dict[str, Any], dict[str, Watched]]:
    """Run gpsec, then plain SUMO, on the same traffic; return what was found, and the processes by their roles.

    Raises:
        RunFailedError: one of them has failed.
    """
    before = _shared_memory()
    with tempfile.TemporaryDirectory() as folder:
        out, log = Path(folder) / "run", Path(folder) / "log"
        options = ("--no-report", "--set", f"sumocfg={city.sumocfg}", "--set", f"duration_s={duration_s}")
        with console.status(f"gpsec, {duration_s:g} simulated seconds"):
            scenario = str(SCENARIOS / "one_plan")
            processes = watch((sys.executable, "-m", "gpsec", "run", scenario, "--out", str(out), *options), log)
        with console.status("plain SUMO, the same"):
            end = str(city.warm_s + duration_s)
            bare = watch((str(SUMO), "-c", str(city.sumocfg), "--no-step-log", "--end", end), log)
        manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))["scenarios"][0]
        found = [sentence for path in sorted(out.rglob("*.csv")) for sentence in not_finite(path)]
    found += [f"{name}: left behind in {SHARED_MEMORY}" for name in sorted(_shared_memory() - before)]
    evaluator = processes["evaluator"].figures()
    settled = duration_s >= SETTLED_S
    if settled and evaluator["growth_mb"] > GROWTH_MB:
        found.append(f"evaluator: grew by {evaluator['growth_mb']:.0f} MiB over the second half of the run")
    if settled and evaluator["handles_late"] > evaluator["handles_half"]:
        found.append("evaluator: has more files open at the end than at half time")
    told = {key: manifest[key] for key in ("vehicle_steps", "vehicles", "steps")} | {"found": found}
    return told, {**processes, "plain SUMO": bare["command"]}


def not_finite(table: Path) -> list[str]:
    """Return a sentence for each column of a table that holds NaN or an infinity; an empty cell is neither."""
    frame = pd.read_csv(table, dtype=str, keep_default_na=False)
    bad = frame.apply(lambda column: column.str.strip().str.lower().isin(NO_NUMBERS))
    return [f"{table.name}: column {name}, line {int(bad[name].idxmax()) + 2}" for name in bad if bad[name].any()]


def _shared_memory() -> set[str]:
    return {path.name for path in SHARED_MEMORY.iterdir()} if SHARED_MEMORY.is_dir() else set()


def _table(processes: Mapping[str, Watched], title: str) -> Table:
    table = Table(title=title)
    table.add_column("process")
    columns = {"at a quarter": "quarter_mb", "half": "half_mb", "late": "late_mb", "peak": "peak_mb"}
    for name in (*columns, "growth over the second half"):
        table.add_column(f"{name}, MiB", justify="right")
    table.add_column("open files", justify="right")
    for role, watched in processes.items():
        of = watched.figures()
        handles = f"{of['handles_half']:.0f} → {of['handles_late']:.0f}"
        table.add_row(role, *(f"{of[key]:.1f}" for key in (*columns.values(), "growth_mb")), handles)
    return table


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.soak",
        description="Run a city for ten million vehicle-steps and watch memory, open files and shared memory; "
        "some ten minutes on two cores.",
        epilog="examples:\n  python -m benchmarks.soak\n  python -m benchmarks.soak --vehicle-steps 30000000\n",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--vehicle-steps", type=int, default=VEHICLE_STEPS, metavar="N", help="default: ten million")
    parser.add_argument(
        "--quick", action="store_true", help="a short run in a small city, to see that it works; growth means nothing"
    )
    parser.add_argument(
        "--out", type=Path, default=ROOT / "results" / "soak.json", metavar="FILE", help="default: results/soak.json"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
