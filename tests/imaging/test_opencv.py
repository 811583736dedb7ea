"""OpenCV is an extra: one module imports it, no run does, and without it one sentence says what to install."""

import ast
import subprocess
import sys
from pathlib import Path

import gpsec

PACKAGE = Path(gpsec.__file__).parent


def imported(path: Path) -> set[str]:
    """Return the packages that a module imports anywhere in it."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module.partition(".")[0])
    return names


def test_one_module_imports_it():
    found = [path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py") if "cv2" in imported(path)]
    assert found == ["imaging/pictures/opencv.py"]


def test_a_run_and_the_command_line_do_not():
    code = "import sys, gpsec.console.commands, gpsec.pipeline.run, gpsec.running.api; print('cv2' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_without_it_a_sentence_names_the_extra():
    code = "import sys; sys.modules['cv2'] = None\nfrom gpsec.imaging.pictures.opencv import opencv\nopencv()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "GpsecError: pictures need the extra 'image' (pip install 'gpsec[image]')" in done.stderr
