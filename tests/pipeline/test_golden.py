"""The golden run: whatever is made faster, the tables keep every byte, for one thread and for two.

The digests hold for one set of mathematical libraries and processor features, since those round the last bit of a
cosine; `GOLDEN` has one entry for each that was tried. After a change that is meant to change results:
``GPSEC_WRITE_GOLDEN=1 pytest -n 0 tests/pipeline/test_golden.py``, and say in CHANGELOG.md what changed.
"""

import hashlib
import json
import os
import platform
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from gpsec.core.threads import Threads
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.overrides import parse_set

GOLDEN = Path(__file__).parent / "golden.json"
TABLES = ("vehicles", "events", "detection", "localization", "safety")
# All eight attacks and both drawn zones begin and end in this time, and vehicles come and go.
CHANGES = (
    "duration_s=75",
    "fleet.settle_s=5",
    "fleet.equipped_share=0.5",
    "outcomes.bootstrap=50",
    *(
        f"plans.{place}.{key}={value}"
        for place in range(8)
        for key, value in (("start_after_s", "[0.0, 10.0]"), ("duration_s", "[5.0, 15.0]"))
    ),
)


def libraries() -> str:
    """What the last bit of a result depends on."""
    features = np._core._multiarray_umath.__cpu_features__
    vectors = "+".join(name for name in ("AVX2", "FMA3", "AVX512F", "AVX512_SKX") if features.get(name))
    versions = " ".join(f"{name}-{version(name)}" for name in ("libsumo", "numba", "numpy", "shapely"))
    return f"{versions} {platform.machine()} {vectors} {'-'.join(platform.libc_ver())}"


@pytest.fixture(scope="module")
def scenario(repository: Path) -> Scenario:
    return load_scenario(repository / "scenarios" / "town", [parse_set(change) for change in CHANGES])


@pytest.fixture(scope="module")
def digests() -> dict[int, dict[str, str]]:
    """What each number of threads gave, so that they can be compared where no digests are kept."""
    return {}


@pytest.mark.parametrize("threads", [1, 2])
def test_the_golden_run_keeps_every_byte(
    scenario: Scenario,
    digests: dict[int, dict[str, str]],
    go: Callable[[Scenario], Path],
    monkeypatch: pytest.MonkeyPatch,
    threads: int,
) -> None:
    monkeypatch.setattr(Threads, "MIN_ROWS", 8)
    folder = go(scenario.model_copy(update={"threads": threads}))
    found = {name: hashlib.sha256((folder / f"{name}.csv").read_bytes()).hexdigest() for name in TABLES}
    digests[threads] = found
    assert all(other == found for other in digests.values())
    golden = json.loads(GOLDEN.read_text("utf-8"))
    if os.environ.get("GPSEC_WRITE_GOLDEN"):
        # Where results have changed, the digests of other machines are no longer true.
        kept = golden if golden.get(libraries(), found) == found else {}
        GOLDEN.write_text(json.dumps(kept | {libraries(): found}, indent=2) + "\n", "utf-8")
        return
    if libraries() not in golden:
        pytest.skip(f"no digests are kept for {libraries()}")
    assert found == golden[libraries()]
