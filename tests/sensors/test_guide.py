"""The guide for a sensor profile, followed whole in a copy of the sources."""

import re
from pathlib import Path

import pytest

from gpsec.testing import PROFILE_CHECKS
from tests.clones import Clone


@pytest.mark.slow
def test_the_guide_leads_to_a_profile_that_passes_lint_and_contract_and_runs(tmp_path: Path) -> None:
    clone = Clone(tmp_path)
    registry = (tmp_path / "gpsec" / "sensors" / "registry.py").read_text("utf-8")
    (nearest,) = re.findall(r"^_CONSUMER = SensorProfile\(.*?^\)\n", registry, re.MULTILINE | re.DOTALL)
    mine = nearest.replace("_CONSUMER", "_BUS").replace('name="consumer"', 'name="bus"')
    clone.edit(
        "gpsec/sensors/registry.py",
        (nearest, f"{nearest}\n{mine}"),
        ("_NUSCENES, _CONSUMER)", "_NUSCENES, _CONSUMER, _BUS)"),
    )
    _document(tmp_path / "docs" / "sensors.md")
    clone.run("docs/generate.py")
    clone.lint("gpsec/sensors")
    files = ["tests/sensors/test_contract.py", "tests/sensors/test_profiles.py", "tests/scenario/test_schema.py"]
    said = clone.run("-m", "pytest", "-n", "0", "-k", "bus or documentation or schema", *files)
    assert int(re.findall(r"(\d+) passed", said)[0]) > len(PROFILE_CHECKS)
    assert "\nbus " in clone.run("-m", "gpsec", "list", "profiles")
    assert ",bus," in (clone.evaluate(profile="bus") / "safety.csv").read_text("utf-8")


def _document(page: Path) -> None:
    """Add a column to the tables of figures, and rows to the list of sources."""
    lines = []
    for line in page.read_text("utf-8").splitlines():
        cells = line.strip("|").split("|")
        if re.match(r"\| (figure \||`\w+` \|( [\d.e-]+ \|){6}$)", line) or (
            re.match(r"\|-+\|", line) and lines and lines[-1].startswith("| figure")
        ):
            line = f"{line}{cells[-1]}|"
        lines.append(line)
        if line.startswith("| consumer |"):
            lines.append(line.replace("| consumer |", "| bus |", 1))
    page.write_text("\n".join(lines) + "\n", "utf-8")
