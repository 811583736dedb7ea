import ast
from pathlib import Path

import gpsec
from gpsec.kernels import ABOVE

PACKAGE = Path(gpsec.__file__).parent


def _imports(path: Path) -> set[str]:
    """Return what a module imports of gpsec, such as ``gpsec.kernels.kernel``."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name.startswith("gpsec.")}


def _layer(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def test_machine_code_depends_on_nothing_that_its_folder_s_name_leaves_out() -> None:
    makers = {f"gpsec.kernels.{name}" for name in ("kernel", "allocating_kernel", "inline")}
    below = 0
    for path in PACKAGE.rglob("*.py"):
        imported = _imports(path)
        if _layer(path) in ABOVE:
            assert not imported & makers, f"{path} has a kernel, in a layer that is above those with kernels"
        elif imported & makers:
            below += 1
            layers = {name.split(".")[1] for name in imported}
            assert not layers & ABOVE, f"{path} has a kernel and imports what is above it"
    assert below > 20
