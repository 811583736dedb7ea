"""No function of gpsec takes more than eight arguments: what belongs together is handed over as one structure.

Constructors of dataclasses and named tuples are no functions: their fields are named where they are written. Commands
are left out, since their arguments are options of the command line.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import gpsec
from gpsec.console.commands import app

PACKAGE = Path(gpsec.__file__).parent
MOST = 8


def test_no_function_takes_more_than_eight_arguments() -> None:
    commands = [info.callback for info in app.registered_commands]
    options = {f"{made.__module__.removeprefix('gpsec.')}.{made.__name__}" for made in commands if made is not None}
    assert {name: count for name, count in long_ones().items() if name not in options} == {}


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("def f(a, b, /, c, *, d=1, **others): ...", 4),
        ("async def f(*all): ...", 0),
        ("class C:\n    def f(self, a): ...", 1),
        ("class C:\n    @classmethod\n    def f(cls, a, b): ...", 2),
        ("class C:\n    @staticmethod\n    def f(a): ...", 1),
        ("def outer():\n    def f(a, b, c): ...", 3),
    ],
)
def test_arguments_are_counted(text: str, count: int) -> None:
    assert dict(counted(ast.parse(text)))["f"] == count


def long_ones() -> dict[str, int]:
    """Return the number of arguments of each function that takes too many, by module and name."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        module = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        for name, count in counted(ast.parse(path.read_text("utf-8"))):
            if count > MOST:
                found[f"{module}.{name}"] = count
    return found


def counted(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Yield name and number of arguments of every function, without `self` and `cls`, and without ``*all``."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            names = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
            yield node.name, len(names) - (names[:1] in (["self"], ["cls"]))
