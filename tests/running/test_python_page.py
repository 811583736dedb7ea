"""The page on Python does what it says, from top to bottom."""

import re
from pathlib import Path

import pytest

import gpsec


def test_the_page_can_be_run(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[object] = []

    def train(*arguments: object, **options: object) -> tuple[str, ...]:
        asked.append((arguments, options))  # it takes minutes
        return ("dsd/tracked", "dsd/nearest")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(gpsec, "train", train, raising=False)
    page = (repository / "docs" / "python.md").read_text("utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert asked
    said = capsys.readouterr().out
    assert "duration=60.0: unknown key 'duration': did you mean 'duration_s'?" in said
    assert re.search(r"\r\d+ s, \d+ vehicles", said)
    assert sorted(path.name for path in (tmp_path / "results").iterdir()) == ["quick", "seed1", "seed2"]
