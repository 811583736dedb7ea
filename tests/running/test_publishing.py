"""A run takes the place of another one: wherever that is cut off, the old one or the new one is whole."""

import builtins
import errno
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from gpsec.core.disk import exchange
from gpsec.core.errors import GpsecError, MachineError
from gpsec.running import publishing
from gpsec.running.publishing import COMPLETE, COPIED, FORMER, MOVED, finish, is_finished, publish

OLD = {"manifest.json": "old", "events.csv": "old", "steps.parquet": "old", "report.html": "old", "trace-a.html": "old"}
NEW = {"manifest.json": "new", "events.csv": "new", "vehicles.csv": "new", "map.geojson": "new"}
NOTES = {"notes.md": "mine", "drafts/one.txt": "mine", "drafts/deep/two.txt": "mine"}
# All of the system that may change what is on the disk.
CALLS = (
    "rename",
    "replace",
    "link",
    "mkdir",
    "rmdir",
    "unlink",
    "remove",
    "chmod",
    "chown",
    "utime",
    "open",
    "sendfile",
)


def write(folder: Path, content: dict[str, str]) -> None:
    for name, text in content.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def content(folder: Path) -> dict[str, str]:
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob("*") if path.is_file()}


class Cut:
    """Lets `cut` happen instead of the k-th call that may change the disk."""

    def __init__(self, number: int, cut: Callable[[], None]) -> None:
        self.left = number
        self.cut = cut

    def count(self) -> None:
        self.left -= 1
        if self.left == 0:
            self.cut()

    def into(self, monkeypatch: pytest.MonkeyPatch, can_exchange: bool) -> None:
        def counted(call: Callable[..., object]) -> Callable[..., object]:
            def counting(*arguments: object, **options: object) -> object:
                self.count()
                return call(*arguments, **options)

            return counting

        def refused(one: Path, other: Path) -> None:
            raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))

        for name in CALLS:
            monkeypatch.setattr(os, name, counted(getattr(os, name)))
        monkeypatch.setattr(os, "fsync", counted(lambda descriptor: None))  # no power fails here, and it takes long
        monkeypatch.setattr(builtins, "open", counted(open))
        monkeypatch.setattr(publishing, "exchange", counted(exchange if can_exchange else refused))


def cut_off(number: int, can_exchange: bool, work: Callable[[], None]) -> bool:
    """Do `work` in a process that ends at its k-th call, without any cleaning up; return whether it came to its end."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            with pytest.MonkeyPatch.context() as monkeypatch:
                Cut(number, lambda: os._exit(9)).into(monkeypatch, can_exchange)
                work()
            status = 0
        finally:
            os._exit(status)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert status in (0, 9)
    return status == 0


@pytest.fixture
def places(tmp_path: Path) -> Callable[[], tuple[Path, Path]]:
    """Give a function that lays out a new run and an output with a former one and notes."""

    def lay_out() -> tuple[Path, Path]:
        for path in tmp_path.iterdir():
            shutil.rmtree(path)
        made, out = tmp_path / ".out.partial" / ".merged", tmp_path / "out"
        write(made, NEW)
        write(out, OLD | NOTES)
        return made, out

    return lay_out


def manifest(out: Path) -> str:
    path = out / "manifest.json"
    return path.read_text() if path.exists() else ""


def is_whole(out: Path) -> bool:
    return content(out) in (OLD | NOTES, NEW | NOTES)


@pytest.mark.parametrize("can_exchange", [True, False])
def test_killed_at_every_point(places: Callable[[], tuple[Path, Path]], can_exchange: bool) -> None:
    outcomes = []
    for number in range(1, 500):
        made, out = places()
        done = cut_off(number, can_exchange, lambda made=made, out=out: publish(made, out, overwrite=True))
        if can_exchange:
            assert is_whole(out), number  # at once, for whoever looks
        assert manifest(out) == "new" or OLD.items() <= (content(out) | content(out / FORMER)).items(), number
        finish(out)  # as the next start does
        assert is_whole(out), number
        assert is_finished(out)
        outcomes.append(content(out) == NEW | NOTES)
        if done:
            break
    assert done
    assert outcomes == sorted(outcomes)  # old up to some point, new from there on
    assert outcomes[0] is False
    assert outcomes[-1] is True
    assert len(outcomes) > 15


def test_the_next_start_may_be_killed_too(places: Callable[[], tuple[Path, Path]]) -> None:
    made, out = places()
    made_whole = False
    for number in range(1, 500):
        made, out = places()
        made_whole = cut_off(number, False, lambda made=made, out=out: publish(made, out, overwrite=True))
        if made_whole:
            break
        again = 1 if not is_finished(out) else 500  # nothing is left to do
        while again < 500 and not cut_off(again, False, lambda out=out: finish(out)):
            again += 1
        assert is_whole(out), (number, again)
    assert made_whole


@pytest.mark.parametrize("can_exchange", [True, False])
def test_refused_at_every_point(places: Callable[[], tuple[Path, Path]], can_exchange: bool) -> None:
    def full() -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    number, cut = 0, Cut(1, full)
    while number == 0 or cut.left <= 0:  # until there are no more calls
        number += 1
        made, out = places()
        cut = Cut(number, full)
        said = ""
        with pytest.MonkeyPatch.context() as patch:
            cut.into(patch, can_exchange)
            try:
                publish(made, out, overwrite=True)
            except MachineError as error:
                said = str(error)
        if "the results of this run are in" in said:
            assert content(out.with_name("out-2")) == NEW
            assert content(out) == OLD | NOTES
        finish(out)
        assert is_whole(out)
        assert "No space left on device" in said or content(out) == NEW | NOTES, number


def test_an_empty_folder_and_a_new_one(tmp_path: Path) -> None:
    for name in ("new", "empty"):
        made, out = tmp_path / f".{name}.partial" / ".merged", tmp_path / name
        write(made, NEW)
        if name == "empty":
            out.mkdir()
        publish(made, out, overwrite=False)
        assert content(out) == NEW


def test_we_do_not_lose_the_ground_under_our_feet(
    places: Callable[[], tuple[Path, Path]], monkeypatch: pytest.MonkeyPatch
) -> None:
    made, out = places()
    before = out.stat().st_ino
    monkeypatch.chdir(out / "drafts")
    publish(made, out, overwrite=True)
    assert out.stat().st_ino == before
    assert content(out) == NEW | NOTES


def test_the_folder_keeps_its_mode_and_its_links(places: Callable[[], tuple[Path, Path]]) -> None:
    made, out = places()
    out.chmod(0o2770)
    (out / "link").symlink_to("nowhere")
    (out / "folder").symlink_to("drafts")
    publish(made, out, overwrite=True)
    assert out.stat().st_mode & 0o7777 == 0o2770
    assert (out / "link").readlink() == Path("nowhere")
    assert (out / "folder").readlink() == Path("drafts")


def test_what_is_written_at_the_last_moment_is_kept(
    places: Callable[[], tuple[Path, Path]], monkeypatch: pytest.MonkeyPatch
) -> None:
    made, out = places()

    def after_an_editor_has_saved(one: Path, other: Path) -> None:
        (out / "drafts" / "saved").write_text("later")
        (out / "drafts" / "saved").replace(out / "drafts" / "one.txt")
        write(out, {"late/note.md": "mine"})
        exchange(one, other)

    monkeypatch.setattr(publishing, "exchange", after_an_editor_has_saved)
    publish(made, out, overwrite=True)
    assert content(out) == NEW | NOTES | {"drafts/one.txt": "later", "late/note.md": "mine"}


def test_a_link_in_a_received_folder_leads_nowhere(tmp_path: Path) -> None:
    out, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    write(out, OLD)
    write(elsewhere, NEW)
    for name in (COPIED, COMPLETE, MOVED):
        (out / name).symlink_to(elsewhere)
    finish(out)
    assert content(elsewhere) == NEW


def test_results_that_cannot_be_put_into_place_are_beside_it(places: Callable[[], tuple[Path, Path]]) -> None:
    made, out = places()
    for name in OLD:
        (out / name).unlink()
    with pytest.raises(GpsecError, match=r"found files that no run wrote.*the results of this run are in .*/out-2\)$"):
        publish(made, out, overwrite=True)
    assert content(out.with_name("out-2")) == NEW
    assert content(out) == NOTES
