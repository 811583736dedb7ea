"""Runs a scenario in this very process and tells its cost and memory: ``python -m benchmarks.evaluate --help``."""

import argparse
import json
import os
import resource
import tempfile
from functools import partial
from pathlib import Path

MEMORY_EVERY_S = 30.0
FEW = 50


def main() -> None:
    """Run, as the command line says, and write a file of JSON."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.evaluate", description=__doc__)
    parser.add_argument("scenario")
    parser.add_argument("json", type=Path, help="file to write: manifest, memory_mb (time, resident), peak_rss_mb")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--recording", type=Path, help="traffic, in the place of SUMO")
    parser.add_argument("--vehicles", type=int, default=1000, metavar="N", help="to make of the recording")
    options = parser.parse_args()
    # Here, and not above: the process of SUMO, which imports this module again, needs none of it.
    from benchmarks.synthetic_traffic import SyntheticTraffic
    from gpsec.core.progress import Progress
    from gpsec.pipeline.run import run_scenario
    from gpsec.scenario import load_scenario
    from gpsec.scenario.overrides import parse_set
    from gpsec.scenario.traffic import sumo_options
    from gpsec.training.collect import recorded_traffic

    memory_mb: list[tuple[float, float]] = []

    def report(progress: Progress) -> None:
        if progress.time_s >= MEMORY_EVERY_S * (len(memory_mb) + 1):
            memory_mb.append((progress.time_s, resident_mb()))

    scenario = load_scenario(options.scenario, [parse_set(text) for text in options.set])
    with tempfile.TemporaryDirectory() as folder:
        if options.recording:
            recording = recorded_traffic(options.recording, sumo_options(scenario).net_file)
            # Once with a few, so that no stage of the run that counts has to fetch its machine code.
            run_scenario(scenario, Path(folder), lambda progress: None, partial(SyntheticTraffic, recording, FEW))
            run_scenario(scenario, Path(folder), report, partial(SyntheticTraffic, recording, options.vehicles))
        else:
            run_scenario(scenario, Path(folder), report)
        manifest = json.loads((Path(folder) / "manifest.json").read_text(encoding="utf-8"))
    answer = {
        "manifest": manifest,
        "memory_mb": memory_mb,
        "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10,
    }
    options.json.write_text(json.dumps(answer))


def resident_mb() -> float:
    """Return the memory of this process that is resident now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


if __name__ == "__main__":
    main()
