"""`fleet.camera.tape` and `fleet.gnss.tape`: found from the scenario's folder, refused in a sentence, told apart."""

from dataclasses import replace
from pathlib import Path

import pytest

from gpsec.core.errors import GpsecError
from gpsec.pipeline.build import lay_ground
from gpsec.pipeline.fingerprint import fingerprint
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set
from gpsec.types.tapes import write_tape
from tests.sensors.test_tapes import recorded


@pytest.fixture
def town(repository: Path, tmp_path: Path) -> Path:
    text = (repository / "scenarios" / "town" / "gpsec.toml").read_text("utf-8")
    sumocfg = next((repository / "scenarios" / "town").glob("*.sumocfg"))
    lines = [line for line in text.splitlines() if not line.startswith("sumocfg")]
    (tmp_path / "gpsec.toml").write_text(f'sumocfg = "{sumocfg}"\n' + "\n".join(lines), "utf-8")
    return tmp_path


def load(folder: Path, *sets: str):
    return load_scenario(folder, [parse_set(text) for text in sets])


def test_a_file_is_found_from_the_folder_of_the_scenario(town):
    write_tape(recorded(pieces=2, piece_s=5.0), town / "mine.npz")
    with (town / "gpsec.toml").open("a") as toml:
        toml.write('\n[fleet.camera]\ntape = "mine.npz"\n')
    scenario = load(town)
    assert scenario.fleet.camera.tape == str(town / "mine.npz")
    assert lay_ground(scenario).sensors.tapes.camera is not None
    assert lay_ground(load(town, "fleet.camera.tape=none")).sensors.tapes.camera is None


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ("nothing.npz", r"--set fleet\.gnss\.tape=.*: fleet\.gnss\.tape: .*nothing\.npz: no such tape"),
        ("nothing", r"fleet\.gnss\.tape: unknown tape 'nothing': .* a file ends in \.npz"),
        ("broken.npz", r"fleet\.gnss\.tape: .*broken\.npz: expected a tape \(npz\), found a broken file"),
    ],
)
def test_a_tape_that_is_none_is_refused(town, monkeypatch, stated, said):
    monkeypatch.chdir(town)
    Path("broken.npz").write_bytes(b"no archive")
    with pytest.raises(GpsecError, match=said):
        load(town, f'fleet.gnss.tape="{stated}"')


def test_a_tape_of_another_sensor_or_too_slow_is_refused_before_the_run(town):
    write_tape(recorded(pieces=2, piece_s=5.0), town / "camera.npz")
    with pytest.raises(GpsecError, match=r"fleet\.gnss\.tape: .*expected a tape of kind 'gnss'"):
        lay_ground(load(town, f'fleet.gnss.tape="{town / "camera.npz"}"'))
    slow = replace(recorded("gnss", pieces=2, piece_s=5.0), rate_hz=1.0)
    write_tape(slow, town / "slow.npz")
    with pytest.raises(GpsecError, match=r"fleet\.gnss\.tape: .*slow\.npz: rate_hz: expected 10 or more"):
        lay_ground(load(town, f'fleet.gnss.tape="{town / "slow.npz"}"'))


def test_the_fingerprint_is_that_of_the_content_not_of_the_place(town):
    tape = recorded("gnss", pieces=2, piece_s=5.0)
    for name, content in (("a", tape), ("b", tape), ("c", replace(tape, errors=2.0 * tape.errors))):
        write_tape(content, town / f"{name}.npz")
    a, b, c = (fingerprint(load(town, f'fleet.gnss.tape="{town / name}.npz"')) for name in "abc")
    assert a == b
    assert len({a, c, fingerprint(load(town))}) == 3
