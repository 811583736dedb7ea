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
        ("_CONSUMER, _URBAN)", "_CONSUMER, _URBAN, _BUS)"),
    )
    clone.run("docs/generate.py")
    clone.lint("gpsec/sensors")
    files = ["tests/sensors/test_contract.py", "tests/sensors/test_profiles.py", "tests/scenario/test_schema.py"]
    said = clone.run("-m", "pytest", "-n", "0", "-k", "bus or documentation or schema", *files)
    assert int(re.findall(r"(\d+) passed", said)[0]) > len(PROFILE_CHECKS)
    assert "\nbus " in clone.run("-m", "gpsec", "list", "profiles")
    assert ",bus," in (clone.evaluate(profile="bus") / "safety.csv").read_text("utf-8")
