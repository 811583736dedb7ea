"""The command line: ``python -m benchmarks``."""

import argparse
import signal
import sys
import tempfile
from pathlib import Path
from types import ModuleType

from rich.console import Console

from benchmarks import adaptive, closed, engines, growth, many, overhead, pixels, scale, startup
from benchmarks.bench import Bench
from benchmarks.city import ROOT
from benchmarks.processes import RunFailedError
from benchmarks.store import FigureStore

GROUPS = (overhead, engines, scale, growth, startup, closed, pixels, adaptive, many)
FIGURES = tuple(figure for group in GROUPS for figure in group.FIGURES)
KEYS = tuple(figure.key for figure in FIGURES)
INTERRUPTED = 130
WIDE = 120
EXAMPLES = """examples:
  python -m benchmarks
  python -m benchmarks --only overhead_ratio --runs 3
  python -m benchmarks --quick --out /tmp/bench.json
"""


def main(arguments: list[str] | None = None) -> int:
    """Measure; return the exit status, which does not depend on the figures."""
    options = _parser().parse_args(arguments)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends what is running, too
    console = Console(emoji=False)
    wanted = set(options.only or KEYS)
    store = FigureStore(options.out, FIGURES, options.quick)
    status = 0
    try:
        with tempfile.TemporaryDirectory() as work:
            bench = Bench(options.runs or (1 if options.quick else 5), options.quick, Path(work), console)
            for group in GROUPS:
                if not wanted.isdisjoint(figure.key for figure in group.FIGURES):
                    status |= _measure(group, bench, wanted, store)
    except KeyboardInterrupt:
        console.print("interrupted")
        status = INTERRUPTED
    for table in store.tables(wide=console.width >= WIDE):
        console.print(table)
    console.print(f"written to {options.out}", highlight=False)
    return status


def _measure(group: ModuleType, bench: Bench, wanted: set[str], store: FigureStore) -> int:
    """Measure a group; return whether something broke, which leaves the other groups alone."""
    bench.console.print(f"[bold]{group.__doc__}[/]", highlight=False, soft_wrap=True)
    try:
        for made in group.measure(bench, wanted):
            kept = {key: sample for key, sample in made.items() if key in wanted}
            store.add(kept, bench.stages)
            line = ", ".join(f"{key} {sample.value:.3g}" for key, sample in kept.items())
            bench.console.print(f"  → {line}", highlight=False, soft_wrap=True)
    except RunFailedError as error:
        bench.console.print(f"failed: {error}", markup=False, highlight=False, style="red", soft_wrap=True)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Measure what gpsec costs against bare SUMO, in alternating runs, for half an hour or more; "
        "rewrite bench.json as it goes.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--only",
        action="append",
        choices=KEYS,
        metavar="KEY",
        help=f"measure this figure, again for more: {', '.join(KEYS)}",
    )
    parser.add_argument("--runs", type=int, metavar="N", help="rounds of each figure (default: 5)")
    parser.add_argument(
        "--quick", action="store_true", help="one round in a small city, to see that it works; the figures mean nothing"
    )
    parser.add_argument(
        "--out", type=Path, default=ROOT / "results" / "bench.json", metavar="FILE", help="default: results/bench.json"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
