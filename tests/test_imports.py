"""What takes long to import is imported only where it is needed: a run starts two processes for each scenario."""

import subprocess
import sys

import pytest

TRAINING = {"torch", "sklearn", "filterpy", "matplotlib"}
HEAVY = TRAINING | {"numpy", "numba", "scipy", "pandas", "pyarrow", "shapely", "pydantic", "rich", "typer", "libsumo"}
LIBSUMO = {"numpy", "libsumo"}  # and what it imports itself


@pytest.mark.parametrize(
    ("modules", "heavy"),
    [
        ("gpsec", HEAVY),
        ("gpsec.cli", HEAVY),
        ("gpsec.console.commands", HEAVY - {"typer"}),
        ("gpsec.console.aftermath, gpsec.console.bars, gpsec.running.batch", HEAVY - {"numpy", "pydantic", "rich"}),
        ("gpsec.pipeline.run", TRAINING | {"numba", "libsumo", "rich", "typer"}),
        ("gpsec.traffic.remote, gpsec.traffic.session, gpsec.pipeline.fleet_choice", HEAVY - LIBSUMO),
    ],
    ids=["package", "entry", "commands", "parent", "scenario", "sumo"],
)
def test_a_process_imports_no_more_than_it_needs(modules: str, heavy: set[str]) -> None:
    code = f"import sys, {modules}; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
