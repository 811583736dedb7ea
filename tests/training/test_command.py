import pytest
from rich.console import Console

from gpsec import cli, shipped
from gpsec.training import command


def test_networks_that_there_are_not_are_named(capsys, tmp_path):
    assert cli.main(["train", "--networks", "mountain,suburbs", "--out", str(tmp_path)]) == 2
    assert "no training network 'suburbs': did you mean 'suburb'?" in capsys.readouterr().err


def test_models_of_some_networks_do_not_replace_those_of_all(capsys):
    assert cli.main(["train", "--networks", "mountain"]) == 2
    assert "say --out DIR" in capsys.readouterr().err


def test_elsewhere_than_on_a_terminal_progress_is_plain_lines(capsys, tmp_path):
    with command._display(Console(force_terminal=False), str(tmp_path)) as display:
        assert display.run("sums", 1, [("three", sum, ((1, 2),)), ("seven", sum, ((3, 4),))]) == [3, 7]
    assert capsys.readouterr().out.splitlines()[-1] == "sums: 2 of 2 done"


@pytest.mark.parametrize("network", command.NETWORKS)
def test_every_training_network_has_a_scenario(network):
    assert (shipped.scenarios() / network / f"{network}.sumocfg").is_file()
