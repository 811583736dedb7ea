"""netconvert on maps that it does not bear."""

from pathlib import Path

import pytest

from gpsec import cli
from gpsec.core.errors import GpsecError, MachineError
from gpsec.opendrive.netconvert import convert_map
from gpsec.sumo import tools as sumotools
from gpsec.sumo.netconvert import Converted
from gpsec.sumo.tools import Limits

from .maps import LINE, TWO_WAY, document, road, write

GOOD = document(road(TWO_WAY))
# netconvert makes points of it for ever.
ENDLESS = document(road(TWO_WAY, LINE.replace("<line/>", '<spiral curvStart="0.01" curvEnd="0.0100000000000001"/>')))
OPTION = "--opendrive.internal-shapes"


def faked(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """Let a shell script be netconvert."""
    program = folder / "sumo" / "bin" / "netconvert"
    program.parent.mkdir(parents=True)
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setattr(sumotools, "program", lambda name: program)


def converted(folder: Path, text: str, limits: Limits | None = None) -> Converted:
    return convert_map(write(folder, text), folder / "net.xml", Path("town.xodr"), limits)


def test_memory_is_bounded(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match=r"^town\.xodr: netconvert needs more memory than the 1 GiB that it may"):
        converted(tmp_path, ENDLESS, Limits(memory_bytes=1 << 30))


def test_time_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    faked(tmp_path, monkeypatch, "exec sleep 600")
    with pytest.raises(MachineError, match=r"^town\.xodr: netconvert was ended, for it had no result after 0 s$"):
        converted(tmp_path, GOOD, Limits(time_s=0.0))


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("kill -9 $$", "netconvert was killed, most likely since the system ran out of memory"),
        ("kill -11 $$", "netconvert ended early (SIGSEGV: a fault of its own)"),
        ("echo 'Error: std::bad_alloc' >&2; exit 1", "netconvert needs more memory than the 4 GiB that it may have"),
    ],
)
def test_what_the_map_need_not_be_guilty_of_is_exit_1(
    script: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    faked(tmp_path, monkeypatch, script)
    monkeypatch.chdir(tmp_path)
    write(tmp_path, GOOD)
    assert cli.main(["import", "map.xodr"]) == 1
    assert capsys.readouterr().err == f"gpsec: error: map.xodr: {says}\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map.xodr", "sumo"]


def test_option_that_the_map_does_not_bear_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    faked(tmp_path, monkeypatch, f'case "$*" in *{OPTION}*) kill -11 $$;; *) touch net.xml;; esac')
    assert converted(tmp_path, GOOD).without == (OPTION,)


def test_two_options_that_the_map_does_not_bear(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = f'case "$*" in *{OPTION}*|*street-names*) echo "Error: no." >&2; exit 1;; *) touch net.xml;; esac'
    faked(tmp_path, monkeypatch, script)
    done = converted(tmp_path, GOOD)
    assert {OPTION, "--output.street-names"} < set(done.without)
    assert done.ignored == ("no",)


def test_map_that_is_refused_with_any_options(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    faked(tmp_path, monkeypatch, 'echo "$*" | grep -q ignore-errors && kill -11 $$; echo "Error: bad map." >&2; exit 1')
    with pytest.raises(GpsecError, match=r"^town\.xodr: netconvert refuses it: bad map$") as caught:
        converted(tmp_path, GOOD)
    assert caught.value.status == 2
