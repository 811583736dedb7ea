import shutil

import pytest

from gpsec.training import recordings
from gpsec.training.recordings import Recordings


class Recorder:
    """In the place of the pool: what it is to record is there at once."""

    def __init__(self):
        self.asked = []

    def run(self, title, work):
        for network, _, (_, seed, target) in work:
            self.asked.append((network, seed))
            target.write_bytes(b"recording")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("GPSEC_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "traffic"


def test_what_is_there_is_not_recorded_again_and_what_is_of_other_traffic_goes(folder, tmp_path, monkeypatch):
    pool = Recorder()
    Recordings.of(["suburb"], tmp_path).record([5, 4, 5], pool)
    assert pool.asked == [("suburb", 4), ("suburb", 5)]
    Recordings.of(["suburb", "mountain"], tmp_path).record([4], pool)
    assert pool.asked[2:] == [("mountain", 4)]
    kept = {path.name for path in folder.iterdir()}
    monkeypatch.setattr(recordings, "digest", lambda layer: "other code")
    Recordings.of(["suburb"], tmp_path).record([4], pool)
    assert pool.asked[3:] == [("suburb", 4)]
    now = {path.name for path in folder.iterdir()}
    assert len(now) == len(kept) == 3
    assert sorted(name.rsplit("-", 1)[0] for name in now - kept) == ["suburb-4"]


def test_a_cache_that_cannot_be_written_is_done_without(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(recordings, "can_keep", lambda kept: False)
    assert Recordings.of(["suburb"], tmp_path / "own").folder == tmp_path / "own"


@pytest.mark.parametrize("changed", ["suburb.rou.xml", "suburb.sumocfg"])
def test_the_digest_is_of_what_sumo_reads(folder, tmp_path, monkeypatch, repository, changed):
    before = Recordings.of(["suburb"], tmp_path).digests
    for name in ("scenarios", "sumo_nets/suburb"):
        shutil.copytree(repository / name, tmp_path / name)
    monkeypatch.setattr(recordings.shipped, "scenarios", lambda: tmp_path / "scenarios")
    assert Recordings.of(["suburb"], tmp_path).digests == before
    file = tmp_path / "scenarios" / "suburb" / changed
    file.write_text(file.read_text() + "<!-- changed -->")
    assert Recordings.of(["suburb"], tmp_path).digests != before
