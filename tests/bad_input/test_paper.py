from pathlib import Path

import pytest

from gpsec import cli
from gpsec.running.workshop import occupied

ROOT = Path(__file__).parents[2]


def test_tables_cannot_be_written_into_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").touch()
    assert cli.main(["paper", "--out", str(tmp_path / "file"), "--dir", str(ROOT / "scenarios")]) == 2
    said = capsys.readouterr().err
    assert "file: no results can be written there" in said
    assert "Traceback" not in said


def test_tables_are_made_once_at_a_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with occupied(tmp_path / "out" / "runs", tmp_path / "out"):
        assert cli.main(["paper", "--out", str(tmp_path / "out"), "--dir", str(ROOT / "scenarios")]) == 2
    assert "another run is being written there" in capsys.readouterr().err


def test_tables_are_made_where_the_scenarios_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["paper", "--dir", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "leave --dir out" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
