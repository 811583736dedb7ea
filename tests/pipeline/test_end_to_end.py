"""Whole runs as a user starts them: every scenario that is in git, and two that nobody here made."""

import json
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import sumo

SCENARIOS = ("town", "highway", "sharp_turns", "slow_curve", "mountain", "suburb", "beltway")
TABLES = {"vehicles", "events", "detection", "localization", "safety"}
GAMES = Path(sumo.SUMO_HOME) / "tools" / "game"
# Early and for all, so that a short run sees attacks begin and end.
EARLY = ("--set", "fleet.settle_s=3", "--set", "outcomes.bootstrap=20")


def listing(folder: Path) -> dict[str, tuple[int, int]]:
    """Size and time of change of everything in `folder`."""
    return {str(path): (path.stat().st_size, path.stat().st_mtime_ns) for path in folder.rglob("*")}


def gpsec(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    words = [str(word) for word in arguments]
    return subprocess.run([sys.executable, "-m", "gpsec", *words], cwd=cwd, capture_output=True, text=True, check=False)


def check_results(folder: Path, scenarios: tuple[str, ...]) -> dict[str, pd.DataFrame]:
    """Look at what every run must have written, and return the tables."""
    tables = {name: pd.read_csv(folder / f"{name}.csv", keep_default_na=False) for name in TABLES}
    for name, table in tables.items():
        assert set(table["scenario"]) == set(scenarios), name
        assert "nan" not in (folder / f"{name}.csv").read_text(encoding="utf-8")
    for scenario in scenarios:
        rows = tables["detection"][tables["detection"]["scenario"] == scenario]
        assert {"chi_square", "cusum", "isolation_forest", "lstm_glr"} <= set(rows["detector"])
    return tables


@pytest.fixture(scope="module")
def all_scenarios(repository, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("all")
    paths = [repository / "scenarios" / name for name in SCENARIOS]
    before = listing(repository / "scenarios")
    done = gpsec("run", *paths, "--duration", 30, "--out", folder / "out", *EARLY, cwd=folder)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "Traceback" not in done.stdout + done.stderr
    assert listing(repository / "scenarios") == before
    return folder / "out"


def manifests(folder: Path) -> dict[str, dict]:
    found = json.loads((folder / "manifest.json").read_text())
    return {one["scenario"]: one for one in found["scenarios"]}


def test_every_scenario_runs(all_scenarios):
    tables = check_results(all_scenarios, SCENARIOS)
    attacks = tables["detection"].groupby("scenario")["attack"].nunique()
    assert (attacks >= 8).all()
    defences = tables["localization"].groupby("scenario")["defence"].nunique()
    assert (defences >= 6).all()
    assert (tables["events"].groupby("scenario").size() > 0).all()
    assert (tables["vehicles"].groupby("scenario").size() > 0).all()


def test_shares_lie_in_their_intervals(all_scenarios):
    table = pd.read_csv(all_scenarios / "safety.csv")
    assert table["line_touched_share"].isna().equals((table["n_vehicles"] == 0) | table["note"].notna())
    for low in [column for column in table.columns if column.endswith("_share_lo")]:
        share = low.removesuffix("_lo")
        least, value, most = table[[low, share, f"{share}_hi"]].dropna().to_numpy().T
        bottom = -1.0 if "_caused_" in share else 0.0  # a twin may touch a line that the attacked vehicle does not
        assert ((least >= bottom) & (least <= value) & (value <= most) & (most <= 1.0)).all(), share
        assert value.max() > 0.0 or share != "line_touched_share"


def test_every_manifest_says_what_was_run(all_scenarios):
    found = manifests(all_scenarios)
    assert set(found) == set(SCENARIOS)
    for name, manifest in found.items():
        assert manifest["vehicles"] > 0, name
        assert manifest["steps"] == 300
        assert manifest["vehicle_steps"] > 0
        assert manifest["configuration"]["duration_s"] == 30.0


PLANS = 'plans=[{attack="constant_bias", share=0.6, start_after_s=[0.0, 5.0], duration_s=[5.0, 10.0]}]'
TOML = """
name = "{name}"
sumocfg = "{sumocfg}"
duration_s = 40.0

[[plans]]
attack = "lane_alias"
share = 0.6
start_after_s = [0.0, 5.0]
duration_s = [5.0, 10.0]
"""


def test_sumos_own_scenarios_by_set_and_by_a_file_of_ours(tmp_path):
    """Braunschweig by `--set`, the motorway junction by a gpsec.toml beside nothing of SUMO's."""
    (tmp_path / "ours").mkdir()
    (tmp_path / "ours" / "gpsec.toml").write_text(TOML.format(name="A10KW", sumocfg=GAMES / "A10KW.sumocfg"))
    before = listing(GAMES)
    for argument, out, extra in (
        (GAMES / "bs3d.sumocfg", "bs3d", ("--duration", 40, "--set", PLANS)),
        ("ours", "A10KW", ()),
    ):
        done = gpsec("run", argument, "--out", out, *extra, *EARLY, cwd=tmp_path)
        assert done.returncode == 0, done.stderr[-2000:]
        assert "Traceback" not in done.stdout + done.stderr
        tables = check_results(tmp_path / out, (out,))
        assert set(tables["events"]["attack"]) == {"constant_bias" if out == "bs3d" else "lane_alias"}
        (manifest,) = manifests(tmp_path / out).values()
        assert manifest["vehicles"] > 5
    assert listing(GAMES) == before
    assert {path.name for path in tmp_path.iterdir()} == {"ours", "bs3d", "A10KW"}
