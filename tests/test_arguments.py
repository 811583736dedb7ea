"""No function of gpsec takes more than eight arguments: what belongs together is handed over as one structure.

Constructors of dataclasses and named tuples are no functions: their fields are named where they are written. Commands
are left out, since their arguments are options of the command line.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import gpsec

PACKAGE = Path(gpsec.__file__).parent
MOST = 8


def test_no_function_takes_more_than_eight_arguments() -> None:
    assert long_ones() == {}


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("def f(a, b, /, c, *, d=1, **others): ...", 4),
        ("async def f(*all): ...", 0),
        ("class C:\n    def f(self, a): ...", 1),
        ("class C:\n    @classmethod\n    def f(cls, a, b): ...", 2),
        ("class C:\n    @staticmethod\n    def f(a): ...", 1),
        ("def outer():\n    def f(a, b, c): ...", 3),
        ("@app.command()\ndef f(a, b): ...", None),
        ("@tools.command('x')\ndef f(a, b): ...", None),
    ],
)
def test_arguments_are_counted(text: str, count: int | None) -> None:
    assert dict(counted(ast.parse(text))).get("f") == count


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
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not any(map(_is_command, node.decorator_list)):
            names = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
            yield node.name, len(names) - (names[:1] in (["self"], ["cls"]))


def _is_command(decorator: ast.expr) -> bool:
    return (
        isinstance(decorator, ast.Call)
        and isinstance(decorator.func, ast.Attribute)
        and decorator.func.attr == "command"
    )
