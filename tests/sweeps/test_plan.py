"""What a plan may not say is one sentence; what one simulation can serve is one."""

from pathlib import Path

import pytest

from gpsec import cli
from gpsec.core.errors import GpsecError
from gpsec.sweeps import cells
from gpsec.sweeps.folder import read_folder, write_list
from gpsec.sweeps.listing import count_of, listed
from gpsec.sweeps.plan import read_plan
from gpsec.sweeps.points import ListedTask

ENTRY = '[[entries]]\nname = "a"\nscenarios = ["slow_curve"]\n'
# Where vehicles hide each other's lanes, each share is a simulation of its own.
CLOCK = '[entries.grid]\nfleet.camera.visibility = ["clock"]\n'


def made(folder: Path, text: str) -> list[ListedTask]:
    path = folder / "plan.toml"
    path.write_text(text)
    return list(listed(read_plan(path), path))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "entries: is missing"),
        (ENTRY + "seed = 3\n", "unknown key 'seed' in entries.0: did you mean 'seeds'?"),
        (ENTRY + ENTRY, "entries: two entries are called 'a'; give one of them another name"),
        (ENTRY + "[entries.grid]\nseed = [1]\n", "seed: expected a key that may vary; seeds are listed in `seeds`"),
        (
            ENTRY + "[entries.grid]\nfleet.profile = []\n",
            "fleet.profile: expected a list of values, found an empty one",
        ),
        (ENTRY + '[entries.grid]\nfleet.profile = "dsd"\n', "expected a list, found 'dsd'"),
        (ENTRY + '[entries.grid]\nfleet.profile = ["dsd", "dsd"]\n', "expected each value once, found 'dsd' twice"),
        (ENTRY + 'seeds = "3-1"\n', "entries.0.seeds: expected ranges that go up"),
        (ENTRY + "seeds = [1, 1]\n", "seeds: expected each once"),
        ('[[entries]]\nname = "a b"\nscenarios = ["town"]\n', "entries.0.name: expected a text of the form"),
        ('[[entries]]\nname = "a"\nscenarios = []\n', "entries.0.scenarios"),
        (ENTRY + '[entries.grid]\nfleet.profil = ["dsd"]\n', "entry 'a': fleet.profil='dsd'"),
        (ENTRY + "[entries.grid]\nplans.stealt.delta = [1.5]\n", "plans.stealt.delta: no plan is called so: did you"),
        (ENTRY + "[entries.grid]\nplans.stealth.delta = [9.0]\n", "delta: expected a number less than or equal to 2"),
        (ENTRY + "[entries.grid]\nplans.stealth.share = [2.0]\n", "share"),
        (ENTRY + CLOCK + 'fleet.equipped_share = ["all"]\n', "expected numbers from 0 to 1, found 'all'"),
        ('[[entries]]\nname = "a"\nscenarios = ["twon"]\n', "entry 'a': "),
        ('[[entries]]\nname = "a"\nscenarios = ["town", "town"]\n', "scenarios: expected each once"),
        ("[entries\n", "not valid TOML"),
    ],
)
def test_a_wrong_plan_is_one_sentence(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(GpsecError) as error:
        made(tmp_path, text)
    assert str(error.value).startswith(f"{tmp_path / 'plan.toml'}: ")
    assert said in str(error.value)


def test_parameters_of_attacks_and_shares_are_cells_of_one_simulation(tmp_path: Path) -> None:
    tasks = made(
        tmp_path,
        ENTRY + 'seeds = "1-3"\n' + CLOCK + 'fleet.profile = ["dsd", "carla"]\n'
        "fleet.equipped_share = [0.2, 1.0, 0.6]\nplans.stealth.delta = [1.2, 1.5]\nplans.stealth.share = [0.1, 0.5]\n",
    )
    assert len(tasks) == 2 * 3  # profiles × seeds, of 72 combinations
    assert count_of(read_plan(tmp_path / "plan.toml")) == 72
    point = tasks[0].point
    assert point.equipped == (0.2, 0.6, 1.0)
    assert point.parameters == {"fleet.profile": "dsd", "fleet.camera.visibility": "clock"}
    assert {name: cell.parameters for name, cell in point.cells.items()} == {
        "stealth~1": {"plans.stealth.delta": 1.2},
        "stealth~2": {"plans.stealth.delta": 1.5},
    }
    assert {cell.shares for cell in point.cells.values()} == {(0.1, 0.5)}
    assert '"share":0.5' in tasks[0].told
    assert '"equipped_share":1.0' in tasks[0].told


def test_more_plans_than_a_simulation_holds_are_several(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cells, "MOST_PLANS", 3)
    tasks = made(tmp_path, ENTRY + "[entries.grid]\nplans.stealth.delta = [1.1, 1.2, 1.3, 1.4, 1.5]\n")
    names = [name for task in tasks for name in task.point.cells]
    assert sorted(names) == [f"stealth~{number}" for number in range(1, 6)]
    assert len({task.fingerprint for task in tasks}) == len(tasks) > 1


def test_a_camera_that_looks_at_the_fleet_has_a_simulation_for_each_share(tmp_path: Path) -> None:
    grid = '[entries.set]\nfleet.camera.visibility = "place"\n[entries.grid]\nfleet.equipped_share = [0.5, 1.0]\n'
    tasks = made(tmp_path, ENTRY + grid)
    assert [task.point.parameters for task in tasks] == [{"fleet.equipped_share": 0.5}, {"fleet.equipped_share": 1.0}]


def test_worlds_are_simulations_of_their_own(tmp_path: Path) -> None:
    grid = 'seeds = "1-2"\nclosed_loop = true\n[entries.grid]\nplans.stealth.delta = [1.2, 1.5]\n'
    tasks = made(tmp_path, ENTRY + grid)
    assert len(tasks) == 2 * 2 * 3  # deltas × seeds × (undefended, defended, their benign twin)
    assert all(task.point.cells == {} for task in tasks)


def test_a_list_is_read_again_as_it_was_written(tmp_path: Path) -> None:
    tasks = made(tmp_path, ENTRY + 'seeds = "1-2"\n' + ENTRY.replace('"a"', '"b"'))
    assert tasks[0].fingerprint == tasks[2].fingerprint  # seed 1 is the scenario's own
    write_list(tmp_path / "made", tasks, {}, None)
    folder = read_folder(tmp_path / "made")
    assert list(folder.labels.values()) == [tasks[0].label, tasks[1].label]
    assert folder.tasks(tasks[0].fingerprint) == [tasks[0], tasks[2]]


def test_a_scenario_that_is_wrong_leaves_no_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(ENTRY + "[entries.grid]\nplans.stealth.detla = [1.1]\n")
    assert cli.main(["sweep", str(path), "--out", str(tmp_path / "made")]) == 2
    assert "unknown key 'detla'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_no_sweep_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(ENTRY)
    taken = tmp_path / "taken"
    taken.mkdir()
    (taken / "thesis.txt").touch()
    for arguments, said in (
        (["--status", str(tmp_path / "nowhere")], "expected the folder of a sweep, found nothing"),
        (["--worker", str(tmp_path)], "expected the folder of a sweep, found no sweep.jsonl in it"),
        ([str(path), "--out", str(taken)], "expected a new or empty folder, or that of a sweep"),
        (
            [str(path), "--out", str(tmp_path / "o"), "--store", str(taken)],
            "expected a store of gpsec, found other files",
        ),
        ([str(tmp_path / "no.toml")], "expected the plan of a sweep, found none"),
        (["--status", "--worker", str(path)], "--worker and --status: expected one of them"),
        (["--status", str(path), "--scheduler", "local"], "--scheduler local: expected it without --status"),
    ):
        assert cli.main(["sweep", *arguments]) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert said in line
    assert not (tmp_path / "o").exists()


def test_a_list_and_a_store_of_another_version(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(ENTRY)
    folder = tmp_path / "made"
    write_list(folder, made(tmp_path, ENTRY), {}, None)
    (folder / "store" / "store.json").write_text('{"gpsec_store": 99}')
    assert cli.main(["sweep", "--worker", str(folder)]) == 2
    assert "expected a store of form 1, found one of form 99" in capsys.readouterr().err
    lines = (folder / "sweep.jsonl").read_text().splitlines()
    digest = read_folder(folder).environment
    (folder / "sweep.jsonl").write_text("\n".join([lines[0].replace(digest, "0" * 64), *lines[1:], ""]))
    for arguments in ([str(path), "--out", str(folder)], ["--worker", str(folder)], ["--failed", str(folder)]):
        (folder / "store" / "store.json").write_text('{"gpsec_store": 1}')
        assert cli.main(["sweep", *arguments]) == 2
        assert "with code and libraries 000000000000, with which it was listed, found" in capsys.readouterr().err
