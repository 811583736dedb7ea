"""What the docs say of detectors is so, and their guide leads to one that works."""

import re
from pathlib import Path

import pytest

from gpsec.detection import forest_training
from gpsec.detection.alarm import GAP_S
from gpsec.detection.calibration import MAX_ROUNDS, MIN_EVENTS, RATES
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.evidence import FORGETTING
from gpsec.detection.forecast import CLIP, DELAY
from gpsec.detection.gate import GATED_AT
from gpsec.detection.isolation_forest import WINDOW
from gpsec.detection.lstm import Lstm
from gpsec.detection.lstm_cell import HIDDEN
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.detection.lstm_glr import DECAYS, LstmGlr
from gpsec.detection.monitor_state import PRESETS
from gpsec.detection.registry import DETECTORS
from gpsec.scenario import parts
from gpsec.testing import DETECTOR_CHECKS, check_detector
from gpsec.types.points import HOLD_S
from tests.clones import Clone

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GUIDE = (DOCS / "adding-a-detector.md").read_text(encoding="utf-8")


def test_parameters_in_the_docs_are_those_of_the_code():
    text = (DOCS / "detection.md").read_text()
    cusum, lstm, sums = Cusum((1.0,), (1.0,), (1.0,)), LstmGlr(()), LstmCusum(())
    stated = [
        f"n = {ChiSquare().window} |",
        f"k = {cusum.slack:g}, clip {cusum.clip:g}, reach {cusum.reach:g}, plausible {cusum.plausible:g},"
        f" margin {cusum.margin:g}",
        f"n = {Lstm(()).window}, {HIDDEN} hidden units, clip {CLIP:g}, delay {Lstm.delay},",
        f"w = {WINDOW}, {forest_training.TREES} trees, ψ = {forest_training.SAMPLES}",
        f"λ = {', '.join(f'{decay:g}' for decay in DECAYS)}, {HIDDEN} hidden units, clip {CLIP:g}, delay {DELAY},"
        f" distrust {lstm.distrust}, plausible {lstm.plausible:g}, enough {lstm.enough:g}",
        f"slack = {sums.slack:g}, reach {sums.reach:g}, clip {sums.clip:g}, margin {sums.margin:g}",
        f"| `joint` | T of innovations and camera together, likewise | λ = {', '.join(f'{d:g}' for d in FORGETTING)} |",
        f"threshold of `joint` at {GATED_AT}",
        *(f"a cap of {cap:g}" if name == "R2" else f'`"{name}"` has {cap:g}' for name, (cap, _) in PRESETS.items()),
        f"at most {HOLD_S:g} s",
        f"more than {GAP_S:g} s",
        *(f"`{rate}`" for rate in RATES),
        *(f"| `{name}` |" for name in DETECTORS),
    ]
    assert [phrase for phrase in stated if phrase not in text] == []
    assert (MIN_EVENTS, MAX_ROUNDS) == (10.0, 8)  # "fewer than ten events", "eight runs"


def _block(after: str, language: str = "") -> str:
    match = re.search(rf"{re.escape(after)}.*?```{language}\n(.*?)```", GUIDE, re.DOTALL)
    assert match
    return match[1]


def _follow(clone: Path) -> None:
    """Do in a copy of the sources what the guide says."""
    (clone / "gpsec" / "detection" / "smooth.py").write_text(_block("## 1. The file", "python"), encoding="utf-8")
    registry = clone / "gpsec" / "detection" / "registry.py"
    entry = _block("## 2. The registry").strip()
    text = registry.read_text(encoding="utf-8")
    bound = "        Told.name: Entry("
    assert bound in text
    text = text.replace(bound, f"        {entry}\n{bound}").replace(
        "\n\n\n@dataclass", "\nfrom gpsec.detection.smooth import Smooth\n\n\n@dataclass", 1
    )
    registry.write_text(text, encoding="utf-8")
    page = clone / "docs" / "detection.md"
    row = _block("## 3. The docs")
    page.write_text(page.read_text(encoding="utf-8").replace("| `told` |", f"{row}| `told` |", 1), encoding="utf-8")


def test_the_example_of_the_guide_keeps_the_contract(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for of in ("_parts", "_modules"):
        monkeypatch.setattr(DETECTORS, of, dict(getattr(DETECTORS, of)))
    monkeypatch.setattr(parts, "_used", {})
    file = tmp_path / "smooth.py"
    file.write_text(_block("## 1. The file", "python"), encoding="utf-8")
    parts.use([f"{file}:Smooth"])
    call = re.search(r"`gpsec\.testing\.check_detector\(lambda profiles: Smooth\(\), threshold=(.*?)\)`", GUIDE)
    assert call
    check_detector(lambda profiles: DETECTORS["smooth"].build([]), threshold=float(call[1]))


@pytest.mark.slow
def test_the_guide_leads_to_a_detector_that_passes_lint_and_contract(tmp_path: Path) -> None:
    clone = Clone(tmp_path)
    _follow(tmp_path)
    tests = ["tests/detection/test_contract.py", "tests/detection/test_docs.py"]
    clone.lint("gpsec")
    clone.run("-m", "mypy", "gpsec/detection")
    said = clone.run("-m", "pytest", "-n", "0", "-m", "not slow", "-k", "smooth or parameters", *tests)
    assert f"{len(DETECTOR_CHECKS) + 1} passed" in said
