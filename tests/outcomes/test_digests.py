"""What the manifest of a run keeps of its tables."""

import hashlib
import json
from pathlib import Path

import pytest

from gpsec.core.errors import GpsecError
from gpsec.outcomes.digests import are_whole, compared, table_digests
from gpsec.outcomes.manifests import read_manifest, stated_digests
from gpsec.outcomes.merging import merge
from gpsec.outcomes.tables import TABLES

LATER = ("report.html", "events.parquet", "notes.csv", "places.geojson", "trace-a.html", "manifest.json")


def written(folder: Path, scenario: str) -> Path:
    folder.mkdir(parents=True)
    for name in TABLES:
        (folder / f"{name}.csv").write_text(f"scenario\n{scenario}\n")
    for name in ("steps.parquet", "map.geojson"):
        (folder / name).write_text(scenario)
    stated = {"scenario": scenario, "tables": table_digests(folder)}
    (folder / "manifest.json").write_text(json.dumps(stated))
    return folder


def test_what_is_made_later_is_not_part_of_it(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", "a")
    before = table_digests(folder)
    assert set(before) == {*(f"{name}.csv" for name in TABLES), "steps.parquet", "map.geojson"}
    assert before["map.geojson"] == hashlib.sha256(b"a").hexdigest()
    for name in LATER:
        (folder / name).write_text("later")
    assert table_digests(folder) == before


def test_every_state_of_a_table(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", "a")
    stated = table_digests(folder)
    (folder / "events.csv").write_text("scenario\nb\n")
    (folder / "vehicles.csv").unlink()
    (folder / "places.csv").unlink()
    (folder / "places.csv").mkdir()
    (folder / "steps-b.parquet").write_text("")
    expected = dict.fromkeys(stated, "whole")
    expected |= {"events.csv": "changed", "vehicles.csv": "missing", "places.csv": "changed"}
    assert compared(folder, stated) == expected | {"steps-b.parquet": "added"}


def test_runs_that_are_joined_get_digests_of_what_was_joined(tmp_path: Path) -> None:
    folders = [written(tmp_path / name, name) for name in ("a", "b")]
    (tmp_path / "both").mkdir()
    merge(folders, tmp_path / "both")
    manifest = read_manifest(tmp_path / "both")
    assert manifest is not None
    assert manifest["tables"] == table_digests(tmp_path / "both")
    assert {"steps-a.parquet", "steps-b.parquet", "map-a.geojson", "map-b.geojson"} < set(manifest["tables"])
    assert are_whole(tmp_path / "both", manifest)
    assert all("tables" not in stated for stated in manifest["scenarios"])


@pytest.mark.parametrize(
    "digests", [None, {}, [], "x", {"gone.csv": "0"}, {"events.csv": 0}, {"": "0"}, {"a" * 999: ""}]
)
def test_a_run_without_digests_is_not_known_to_be_whole(tmp_path: Path, digests: object) -> None:
    folder = written(tmp_path / "run", "a")
    assert not are_whole(folder, {"tables": digests})


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[]",
        "7",
        "{}",
        '{"scenarios": {}}',
        '{"scenarios": []}',
        '{"scenarios": [{}]}',
        '{"scenarios": [7]}',
        '{"scenarios": [{"scenario": 7}]}',
        '{"scenarios": [{"scenario": "../a"}]}',
        '{"scenarios": [{"scenario": "a"}, {"scenario": "a"}]}',
        '{"scenarios": [{"scenario": "\\ud800"}]}',
        "[" * 100_000,
        b"\xff",
    ],
)
def test_other_manifests_are_refused(tmp_path: Path, content: str | bytes) -> None:
    (tmp_path / "manifest.json").write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(GpsecError, match=r"manifest\.json: expected the manifest of a run, found other data"):
        read_manifest(tmp_path)


@pytest.mark.parametrize("digests", ["x", [], {"events.csv": 7}, {"../events.csv": ""}])
def test_other_digests_are_refused(tmp_path: Path, digests: object) -> None:
    with pytest.raises(GpsecError, match=r"manifest\.json: tables: expected name -> SHA-256, found"):
        stated_digests(tmp_path, {"tables": digests})
