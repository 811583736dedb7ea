"""The guide for a response, followed whole in a copy of the sources."""

import re
from pathlib import Path

import pytest

from gpsec.testing import RESPONSE_CHECKS
from tests.clones import ROOT, Clone

GUIDE = (ROOT / "docs" / "adding-a-response.md").read_text("utf-8")


@pytest.mark.slow
def test_the_guide_leads_to_a_response_that_passes_lint_and_contract_and_runs(tmp_path: Path) -> None:
    clone = Clone(tmp_path)
    (code,) = re.findall(r'^```python\n(""".*?)^```$', GUIDE, re.MULTILINE | re.DOTALL)
    (tmp_path / "gpsec" / "localization" / "snap.py").write_text(code, "utf-8")
    clone.edit(
        "gpsec/localization/registry.py",
        ("\n\n_OWN", "\nfrom gpsec.localization.snap import Snap\n\n_OWN"),
        ("    Ukf5Rollback,\n)", "    Ukf5Rollback,\n    Snap,\n)"),
    )
    clone.run("docs/generate.py")
    clone.lint("gpsec/localization")
    clone.run("-m", "mypy", "gpsec/localization")
    files = ["tests/localization/test_contract.py", "tests/scenario/test_schema.py"]
    said = clone.run("-m", "pytest", "-n", "0", "-k", "snap or schema", *files)
    assert int(re.findall(r"(\d+) passed", said)[0]) > len(RESPONSE_CHECKS)
    assert "\nsnap " in clone.run("-m", "gpsec", "list", "responses")
    assert "told+snap" in (clone.evaluate(response="snap") / "safety.csv").read_text("utf-8")
