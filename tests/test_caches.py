"""Entries are read only as they were written, and from folders that nobody else can change."""

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from gpsec.core import caches, trust
from gpsec.core.errors import GpsecError
from gpsec.hdmap import map as maps
from gpsec.hdmap.error import MapError

NOBODY = 65534


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("GPSEC_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@contextmanager
def only_reading(folder: Path) -> Iterator[None]:
    """Let this process read and not write a folder: as somebody else where it is root's, else without permission."""
    if os.geteuid() == 0:
        os.seteuid(NOBODY)
        try:
            yield
        finally:
            os.seteuid(0)
        return
    places = [folder, *(path for path in folder.rglob("*") if path.is_dir())]
    for place in places:
        place.chmod(0o555)
    try:
        yield
    finally:
        for place in places:
            place.chmod(0o755)


@pytest.fixture
def public(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder that everybody can come to, the cache in it."""
    with tempfile.TemporaryDirectory(dir="/tmp") as name:
        Path(name).chmod(0o755)
        monkeypatch.setenv("GPSEC_CACHE", f"{name}/cache")
        yield Path(name)


def flip(path: Path, place: int, bit: int = 3) -> None:
    content = bytearray(path.read_bytes())
    content[place] ^= 1 << bit
    path.write_bytes(content)


def test_an_entry_is_read_as_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "a" / "entry"
    assert caches.read(path) is None
    caches.write(path, b"first")
    caches.write(path, b"second")
    assert caches.read(path) == b"second"
    caches.write(path, b"")
    assert caches.read(path) == b""
    assert [entry.name for entry in path.parent.iterdir()] == ["entry"]


def test_each_damaged_byte_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "entry"
    caches.write(path, b"content")
    whole = path.read_bytes()
    for place in range(len(whole)):
        flip(path, place)
        assert caches.read(path) is None, place
        path.write_bytes(whole)
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        assert caches.read(path) is None, length
    path.write_bytes(whole)
    assert caches.read(path) == b"content"


def test_an_entry_that_others_can_write_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "entry"
    caches.write(path, b"content")
    path.chmod(0o666)
    assert caches.read(path) is None
    caches.write(path, b"content")
    assert caches.read(path) == b"content"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
def test_an_entry_of_somebody_else_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "entry"
    caches.write(path, b"content")
    os.chown(path, NOBODY, -1)
    assert caches.read(path) is None


def test_a_mask_of_nothing_leaves_entries_that_only_we_can_write(root: Path) -> None:
    before = os.umask(0)
    try:
        path = caches.cache_folder() / "below" / "entry"
        caches.write(path, b"content")
        with caches.new_folder(root / "folder" / "one") as part:
            (part / "file").write_bytes(b"content")
    finally:
        os.umask(before)
    assert caches.read(path) == b"content"
    assert caches.is_whole(root / "folder" / "one")
    assert all(not place.stat().st_mode & 0o022 for place in (root, *root.rglob("*")))


def test_a_folder_is_whole_as_it_was_made(tmp_path: Path) -> None:
    folder = tmp_path / "maps" / "one"
    assert not caches.is_whole(folder)
    with caches.new_folder(folder) as part:
        (part / "a").write_bytes(b"first")
        (part / "b").write_bytes(b"second")
    assert caches.is_whole(folder)
    for change in (
        lambda: flip(folder / "a", 2),
        lambda: (folder / "b").unlink(),
        lambda: (folder / "c").touch(),
        lambda: flip(folder / "SHA256SUMS", 5),
        lambda: (folder / "SHA256SUMS").write_bytes(b"\xff"),
        lambda: (folder / "SHA256SUMS").unlink(),
        lambda: (folder / "a").chmod(0o666),
        lambda: folder.chmod(0o777),
    ):
        change()
        assert not caches.is_whole(folder)
        with caches.new_folder(folder) as part:
            (part / "a").write_bytes(b"first")
            (part / "b").write_bytes(b"second")
        assert caches.is_whole(folder)
    assert [path.name for path in folder.parent.iterdir()] == ["one"]


def test_digests_of_a_folder_are_those_of_sha256sum(tmp_path: Path) -> None:
    with caches.new_folder(tmp_path / "one") as part:
        (part / "a").write_bytes(b"first")
    said = (tmp_path / "one" / "SHA256SUMS").read_text()
    assert said == f"{hashlib.sha256(b'first').hexdigest()}  a\n"


def test_a_folder_that_fails_leaves_nothing(tmp_path: Path) -> None:
    def fail() -> None:
        with caches.new_folder(tmp_path / "one"):
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_where_the_environment_says(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert caches.cache_folder() == root
    assert caches.kernels_folder() == root / "kernels"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(root / "numba"))
    assert caches.kernels_folder() == root / "numba" / "gpsec"
    assert caches.kernel_folder("gpsec.hdmap").parent == root / "numba" / "gpsec"


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o757])
def test_a_folder_that_others_can_write_is_refused(root: Path, mode: int) -> None:
    root.mkdir()
    root.chmod(mode)
    with pytest.raises(
        GpsecError, match=rf"GPSEC_CACHE=.*only you and root.*others can write {root} \(mode {mode:o}\)"
    ):
        caches.cache_folder()


def test_a_parent_that_others_can_write_is_refused_unless_they_cannot_rename_there(root: Path) -> None:
    root.mkdir()
    root.parent.chmod(0o777)
    with pytest.raises(GpsecError, match=f"others can write {root.parent} "):
        caches.cache_folder()
    root.parent.chmod(0o1777)  # as /tmp
    assert caches.cache_folder() == root


def test_a_folder_within_that_others_can_write_is_refused(root: Path) -> None:
    (root / "kernels").mkdir(parents=True)
    (root / "kernels").chmod(0o777)
    with pytest.raises(GpsecError, match=f"others can write {root / 'kernels'} "):
        caches.kernels_folder()


def test_a_link_is_followed_before_it_is_trusted(root: Path, tmp_path: Path) -> None:
    (tmp_path / "open").mkdir()
    (tmp_path / "open" / "mine").mkdir()
    root.symlink_to(tmp_path / "open" / "mine")
    assert caches.cache_folder() == tmp_path / "open" / "mine"
    (tmp_path / "open").chmod(0o777)
    with pytest.raises(GpsecError, match=f"others can write {tmp_path / 'open'} "):
        caches.cache_folder()


def test_numba_s_folder_is_looked_at_too(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root.mkdir()
    root.chmod(0o777)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(root))
    with pytest.raises(GpsecError, match=r"NUMBA_CACHE_DIR=.*name another one in NUMBA_CACHE_DIR"):
        caches.kernels_folder()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give folders away")
def test_a_folder_of_somebody_else_is_refused(root: Path) -> None:
    root.mkdir()
    os.chown(root, NOBODY, -1)
    with pytest.raises(GpsecError, match=f"{root} belongs to 'nobody'"):
        caches.cache_folder()


def test_a_group_counts_as_others_unless_it_is_the_user_s_own(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root.mkdir()
    root.chmod(0o775)
    monkeypatch.setattr(trust, "_is_private", lambda group: group == root.stat().st_gid)
    assert caches.cache_folder() == root
    monkeypatch.setattr(trust, "_is_private", lambda group: False)
    with pytest.raises(GpsecError, match="others can write"):
        caches.cache_folder()


def test_a_cache_for_reading_is_read_and_left_alone(public: Path) -> None:
    path = caches.cache_folder() / "entry"
    caches.write(path, b"content")
    with caches.new_folder(public / "cache" / "maps" / "one") as part:
        (part / "a").write_bytes(b"first")
    before = sorted(public.rglob("*"))
    with only_reading(public / "cache"):
        assert caches.cache_folder() == public / "cache"
        assert caches.read(path) == b"content"
        assert caches.is_whole(public / "cache" / "maps" / "one")
        assert not caches.can_keep(public / "cache" / "kernels" / "not there")
        caches.write(path, b"other")
        with pytest.raises(PermissionError), caches.new_folder(public / "cache" / "maps" / "two"):
            pass
    assert caches.can_keep(public / "cache" / "kernels" / "not there")
    assert caches.read(path) == b"content"
    assert sorted(public.rglob("*")) == before


def test_maps_are_read_from_a_cache_for_reading(public: Path, plain_net, monkeypatch) -> None:
    net = public / "road.net.xml"
    made = plain_net('id="a" x="0" y="0"\nid="b" x="200" y="0"', 'id="ab" from="a" to="b" numLanes="1" speed="13.9"')
    net.write_bytes(made.read_bytes())
    net.chmod(0o644)
    compiled: list[tuple[float, ...]] = []
    compile_map = maps.compile_map

    def watched(net: Path, spacings_m: tuple[float, ...], error: MapError) -> maps.HDMap:
        compiled.append(spacings_m)
        return compile_map(net, spacings_m, error)

    monkeypatch.setattr(maps, "compile_map", watched)
    maps.load_map(net, (5.0,))
    maps.load_map(net, (5.0,))  # imports what reading takes, which somebody else may not be able to
    before = sorted(public.rglob("*"))
    with only_reading(public / "cache"):
        assert maps.load_map(net, (5.0,)).spacings_m == (5.0,)
        assert maps.load_map(net, (2.0,)).spacings_m == (2.0,)
    assert compiled == [(5.0,), (2.0,)]
    assert sorted(public.rglob("*")) == before


def test_stale_entries_are_those_that_nothing_here_will_read(root: Path) -> None:
    kept = [
        caches.kernel_folder("gpsec.core.noise") / "entry",
        caches.kernel_folder("tests") / "entry",
        caches.warmup_file("a machine"),
        caches.map_folder("a" * 64) / "net.json",
        caches.plotly_file(),
        root / "plotly.txt",  # whatever else lies in a folder that the user has named
        root / ".profile",
        root / "maps" / "europe",
        root / "kernels" / "linux-6.1",
    ]
    old = [
        root / "kernels" / f"gpsec.core.noise-{'0' * 16}",
        root / "kernels" / f"no_such_package-{'0' * 16}",
        root / "kernels" / f"warmup-{'0' * 16}-{'1' * 16}",
        root / "kernels" / ("0" * 16),
        root / "maps" / f"map-{'0' * 16}-{'1' * 32}",
        root / "maps" / ("0" * 32),
        root / "plotly-1.0.0.packed",
        root / f"plotly-{'0' * 16}",
        root / ".gpsec-0123456789ab",
        root / "maps" / ".gpsec-0123456789ab",
        kept[0].parent / ".gpsec-0123456789ab",
    ]
    assert caches.stale() == []
    for path in kept + old:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert caches.stale() == sorted(old)
