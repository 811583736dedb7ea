"""The command line: ``python -m tests.fuzz``, or ``make fuzz``."""

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from itertools import count
from multiprocessing.connection import wait
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from .attempt import lay_out
from .material import Material, make
from .readers import readers
from .workers import Case, Worker

TOLD_EVERY_S = 30.0


def main() -> int:
    """Try inputs; return 1 where one failed."""
    options = _parser().parse_args()
    console = Console(emoji=False)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "material").mkdir()
        material = make(Path(folder) / "material")
        names = options.only or sorted(readers(material))
        cases = (Case(name, number) for number in count(options.first) for name in names)
        failed = _drive(cases, options.inputs, [Worker(material, Path(folder) / f"{at}") for at in range(options.jobs)])
        for case, sentence in failed.items():
            _keep(case, sentence, material, options.out)
    by_reader = Counter(case.reader for case in failed)
    console.print(f"{options.inputs} inputs, {len(failed)} failed {dict(by_reader) or ''}", highlight=False)
    if failed:
        console.print(f"kept in {options.out}", highlight=False)
    return 1 if failed else 0


def _drive(cases: Iterator[Case], inputs: int, workers: list[Worker]) -> dict[Case, str]:
    """Try so many cases; return what was wrong with those that failed."""
    failed: dict[Case, str] = {}
    columns = (
        TextColumn("fuzz"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[failed]}"),
    )
    console = Console(stderr=True)
    busy: dict[Worker, Case] = {}
    sent = done = 0
    told_s = time.monotonic()
    try:
        with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
            task = bar.add_task("", total=inputs, failed="")
            while done < inputs:
                for worker in workers:
                    if worker not in busy and sent < inputs:
                        busy[worker] = next(cases)
                        worker.send(busy[worker])
                        sent += 1
                wait([worker.connection for worker in busy], timeout=1.0)
                for worker in [worker for worker in busy if worker.connection.poll()]:
                    case = busy.pop(worker)
                    if sentence := worker.answer():
                        failed[case] = sentence
                    done += 1
                    bar.update(task, completed=done, failed=f"{len(failed)} failed" if failed else "")
                if not console.is_terminal and time.monotonic() >= told_s + TOLD_EVERY_S:
                    told_s = time.monotonic()
                    print(f"fuzz: {done} of {inputs}, {len(failed)} failed", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        console.print("interrupted")
    finally:
        for worker in workers:
            worker.close()
    return failed


def _keep(case: Case, sentence: str, material: Material, out: Path) -> None:
    folder = out / f"{case.reader}-{case.number}"
    lay_out(case.reader, readers(material)[case.reader], case.number, folder)
    (folder / "WHAT.txt").write_text(sentence, encoding="utf-8", errors="replace")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz",
        description="Damage what every reader reads, and keep the inputs that end in a traceback or a crash.",
        epilog="examples:\n  python -m tests.fuzz --inputs 100000\n  python -m tests.fuzz --only models --first 5000\n",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--inputs", type=int, default=100_000, metavar="N", help="how many (default: 100000)")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="the number to begin with (default: 0)")
    parser.add_argument("--only", action="append", metavar="READER", help="this reader, again for more")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="processes (default: 2)")
    parser.add_argument("--out", type=Path, default=Path("build/fuzz"), metavar="DIR", help="default: build/fuzz")
    return parser


if __name__ == "__main__":
    sys.exit(main())
