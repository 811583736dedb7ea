from pathlib import Path

import pytest

from gpsec.console import aftermath
from gpsec.running import batch, impact

from .runs import fake_run


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def faked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace pipeline, summary and report."""
    real = batch.run_scenarios
    monkeypatch.setattr(batch, "run_scenarios", lambda *args: real(*args[:4], fake_run))
    monkeypatch.setattr(aftermath, "show_findings", lambda folder, all_: print(f"tables of {folder.name}"))
    monkeypatch.setattr(impact, "write_impact", lambda folder: None)
    monkeypatch.setattr(aftermath, "_report", lambda folder, messages: None)
