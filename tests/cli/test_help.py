"""What the command line says of itself: parts, commands, examples and the schema."""

import json
import re
from pathlib import Path

import pytest

from gpsec import cli
from gpsec.attacks.registry import ATTACKS


def test_list_shows_a_line_a_part(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["list", "attacks"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert {"adaptive", "blind_drift", "drift"} <= {line.split()[0] for line in lines}
    assert len(lines) == len(ATTACKS)
    assert any(line.startswith("drift ") and "rate_mps = 0.2" in line for line in lines)
    assert cli.main(["list", "profiles"]) == 0
    assert {line.split()[0] for line in capsys.readouterr().out.splitlines()} == {
        *("dsd", "carla", "dsd_sim", "carla_sim", "nuscenes", "consumer", "urban")
    }
    assert cli.main(["list", "detectors"]) == 0
    names = {line.split()[0] for line in capsys.readouterr().out.splitlines()}
    learned = {"cusum", "isolation_forest", "lstm", "lstm_glr", "lstm_cusum"}
    assert names == {"chi_square", *learned, "innovation", "joint", "separation", "told", "never"}
    assert cli.main(["list", "responses"]) == 0
    assert {line.split()[0] for line in capsys.readouterr().out.splitlines()} == {
        *("none", "gate", "dead_reckoning", "ukf", "rollback", "consider_ukf", "ukf5", "ukf5_rollback")
    }
    assert cli.main(["list", "scenarios", "--dir", str(Path(__file__).parents[2] / "scenarios")]) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("town ")


COMMANDS = [
    "run",
    "replay",
    "show",
    "report",
    "table",
    "figure",
    "verify",
    "trace",
    "check",
    "import",
    "demand",
    "list",
    "new",
    "clean",
    "schema",
    "train",
    "calibrate",
    "paper",
    "stress",
    "sweep",
    "search",
    "bench-detector",
    "dataset",
    "judge",
    "image",
]


def test_all_commands_are_listed_in_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--help"]) == 0
    listed = re.findall(r"^  ([a-z-]+)  ", capsys.readouterr().out.partition("Commands:")[2], re.MULTILINE)
    assert listed == COMMANDS


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)])
def test_help_has_examples(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*command, "--help"]) == 0
    shown = capsys.readouterr().out
    assert "Examples:\n    gpsec " in shown


def test_no_arguments_show_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 0
    assert "Usage: gpsec" in capsys.readouterr().out


def test_the_schema_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "gpsec.toml"
