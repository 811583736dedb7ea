"""A copy of the sources in which a test follows a guide."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
# A scenario of 20 s that needs nothing that is trained.
SHORT = """
sumocfg = "{root}/scenarios/slow_curve/slow_curve.sumocfg"
duration_s = 20.0
[fleet]
settle_s = 1.0
profile = "{profile}"
[detection]
detectors = []
[[defences]]
detector = "told"
response = "{response}"
{plans}"""
EVERYBODY = '[[plans]]\nattack = "constant_bias"\nshare = 1.0\n'


class Clone:
    """The files that git keeps, in a folder of their own.

    Attributes:
        path: the folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
        for name in listed.stdout.splitlines():
            if (ROOT / name).is_file():
                (path / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(ROOT / name, path / name)

    def edit(self, name: str, *changes: tuple[str, str]) -> None:
        """Replace the first place of each text in a file, all of which there must be."""
        file = self.path / name
        text = file.read_text("utf-8")
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new, 1)
        file.write_text(text, "utf-8")

    def run(self, *arguments: str) -> str:
        """Run Python in the folder and return what it prints."""
        environment = os.environ | {"PYTHONPATH": str(self.path)}
        command = [sys.executable, *arguments]
        done = subprocess.run(command, cwd=self.path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{arguments}: {done.stdout}\n{done.stderr}"
        return done.stdout

    def lint(self, *names: str) -> None:
        """Run the linters over some files or folders."""
        self.run("-m", "ruff", "check", *names)
        self.run("-m", "ruff", "format", "--check", *names)

    def evaluate(self, profile: str = "dsd", response: str = "none", plans: str = EVERYBODY) -> Path:
        """Run a short scenario and return the folder of its results."""
        text = SHORT.format(root=self.path, profile=profile, response=response, plans=plans)
        (self.path / "mine.toml").write_text(text, "utf-8")
        self.run("-m", "gpsec", "run", "mine.toml", "--out", "found", "--no-report")
        return self.path / "found"
