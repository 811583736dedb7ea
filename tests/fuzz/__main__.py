"""The command line: ``python -m tests.fuzz``, or ``make fuzz``."""

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from itertools import count, islice
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
        workers = [Worker(material, Path(folder) / f"{at}") for at in range(options.jobs)]
        failed: list[Case] = []
        done = 0
        for case, sentence in _tried(islice(cases, options.inputs), options.inputs, workers):
            done += 1
            if sentence:
                failed.append(case)
                _keep(case, sentence, material, options.out)
    by_reader = Counter(case.reader for case in failed)
    console.print(f"{done} inputs, {len(failed)} failed {dict(by_reader) or ''}", highlight=False)
    if failed:
        console.print(f"kept in {options.out}", highlight=False)
    return 1 if failed else 0


def _tried(cases: Iterator[Case], inputs: int, workers: list[Worker]) -> Iterator[tuple[Case, str]]:
    """Yield the cases, each with what was wrong with it, until there are no more or the user has had enough."""
    console = Console(stderr=True)
    columns = (TextColumn("fuzz"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    busy: dict[Worker, Case] = {}
    done, told_s = 0, time.monotonic()
    try:
        with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
            task = bar.add_task("", total=inputs)
            while done < inputs:
                for worker in [worker for worker in workers if worker not in busy]:
                    if (case := next(cases, None)) is not None:
                        busy[worker] = case
                        worker.send(case)
                wait([worker.connection for worker in busy], timeout=1.0)
                for worker in [worker for worker in busy if worker.ready]:
                    yield busy.pop(worker), worker.answer()
                    done += 1
                    bar.update(task, completed=done)
                if not console.is_terminal and time.monotonic() >= told_s + TOLD_EVERY_S:
                    told_s = time.monotonic()
                    print(f"fuzz: {done} of {inputs}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        console.print("interrupted")
    finally:
        for worker in workers:
            worker.close()


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
