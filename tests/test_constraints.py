"""`constraints.txt` pins all that `pyproject.toml` asks for, within the bounds given there."""

import re
import tomllib

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name


@pytest.fixture(scope="module")
def pinned(repository):
    lines = (repository / "constraints.txt").read_text().splitlines()
    pins = [line.split("==") for line in lines if line and not line.startswith("#")]
    return {canonicalize_name(name): version for name, version in pins}


@pytest.fixture(scope="module")
def wanted(repository):
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"].values()
    return [Requirement(line) for line in (*project["dependencies"], *(line for extra in extras for line in extra))]


def test_every_requirement_is_pinned_within_its_bounds(pinned, wanted):
    for requirement in wanted:
        assert pinned[canonicalize_name(requirement.name)] in requirement.specifier, requirement


def test_a_major_release_of_what_makes_the_bytes_does_not_come_unasked(repository):
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    for line in project["dependencies"]:
        assert re.search(r"<|==", line), line
