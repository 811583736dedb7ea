"""One meaning a name: a public class, function or constant of gpsec is defined in one module."""

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import gpsec
from gpsec.testing import ATTACK_CHECKS, DETECTOR_CHECKS, PROFILE_CHECKS, RESPONSE_CHECKS, STEERING_CHECKS

PACKAGE = Path(gpsec.__file__).parent

# Rules of `gpsec.testing` that more than one kind of part keeps.
CHECKS = chain(ATTACK_CHECKS, DETECTOR_CHECKS, PROFILE_CHECKS, RESPONSE_CHECKS, STEERING_CHECKS)
RULES = {name for name, kinds in Counter(check.__name__ for check in CHECKS).items() if kinds > 1}

# Names that have the same meaning wherever they are defined.
SAME_ROLE = {"main", "T", "check", "run", "train", "calibrate", "replay", "sweep", "load", *RULES}
"""A program's entry point; a type variable; a command and the function that does it in Python; a rule that several
kinds of parts keep; what reads the results of a run, and that of a run or a sweep."""


def test_a_public_name_has_one_home() -> None:
    homes = public_names()
    shared = {name: modules for name, modules in homes.items() if len(modules) > 1 and name not in SAME_ROLE}
    assert shared == {}


def test_what_may_have_several_homes_still_does() -> None:
    homes = public_names()
    assert {name for name in SAME_ROLE if len(homes.get(name, [])) < 2} == set()


def test_names_are_found_where_they_are_defined() -> None:
    text = """
import a
from b import c
LIMIT_M: float = 1.0
LOW, (HIGH, _MIDDLE) = 1, (2, 3)
class Car:
    x = 1
def drive():
    y = 1
"""
    assert list(_defined(ast.parse(text))) == ["LIMIT_M", "LOW", "HIGH", "Car", "drive"]


def public_names() -> dict[str, list[str]]:
    """Return the modules that define each public name at their top level."""
    homes: dict[str, list[str]] = defaultdict(list)
    for path in sorted(PACKAGE.rglob("*.py")):
        for name in set(_defined(ast.parse(path.read_text(encoding="utf-8")))):
            homes[name].append(path.relative_to(PACKAGE).as_posix())
    return homes


def _defined(module: ast.Module) -> Iterator[str]:
    for node in module.body:
        found: list[str] = []
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            found = [node.name]
        elif isinstance(node, ast.Assign):
            found = list(chain.from_iterable(map(_targets, node.targets)))
        elif isinstance(node, ast.AnnAssign):
            found = list(_targets(node.target))
        yield from (name for name in found if not name.startswith("_"))


def _targets(target: ast.expr) -> Iterator[str]:
    for node in ast.walk(target):
        if isinstance(node, ast.Name):
            yield node.id
