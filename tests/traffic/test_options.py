import gzip
from pathlib import Path

import pytest
import sumo

from gpsec.core.errors import GpsecError
from gpsec.traffic.options import resolve_options
from gpsec.traffic.optiontable import parse_template, sumo_options_by_name

GAME = Path(sumo.SUMO_HOME) / "tools" / "game"


def value(arguments, name):
    return arguments[arguments.index(f"--{name}") + 1] if f"--{name}" in arguments else None


@pytest.mark.parametrize(
    ("own", "asked", "step_s", "noted"),
    [
        ("", None, 0.1, True),  # SUMO's default is 1 s
        ('<step-length value="0.5"/>', None, 0.1, True),
        ('<step-length value="0:0:0.5"/>', None, 0.1, True),
        ('<step-length value="0.1"/>', None, 0.1, False),
        ('<step-length value=".05"/>', None, 0.05, False),
        ('<step-length value="0.05"/>', 0.2, 0.2, False),
    ],
)
def test_step_is_the_scenarios_own_up_to_a_tenth(scenario, own, asked, step_s, noted):
    options = resolve_options(scenario(options=own), seed=1, step_s=asked)
    assert options.step_s == step_s
    assert value(options.arguments, "step-length") == str(step_s)
    assert any("step-length lowered" in note for note in options.notes) == noted


@pytest.mark.parametrize("asked", [0.21, 1.0, 0.0, -0.1, float("nan")])
def test_step_asked_for_outside_the_filters_range_is_refused(scenario, asked):
    with pytest.raises(GpsecError, match=r"traffic.step_s: expected 0.001 to 0.2 s"):
        resolve_options(scenario(), seed=1, step_s=asked)


@pytest.mark.parametrize(
    ("own_s", "said"),
    [("0.2", "traffic.step_s = 0.2 keeps the scenario's own"), ("1", "traffic.step_s = 0.2 comes closest to it")],
)
def test_what_is_changed_is_said_once_with_how_to_keep_it(scenario, own_s, said):
    notes = resolve_options(scenario(options=f'<step-length value="{own_s}"/>'), seed=1).notes
    assert [said in note for note in notes] == [True, False]
    assert "traffic.lateral_resolution_m = 0 keeps" in notes[1]
    kept = resolve_options(scenario(), seed=1, step_s=0.2, lateral_resolution_m=0.0)
    assert kept.notes == ()
    assert "--lateral-resolution" not in kept.arguments


def test_begin_is_the_scenarios_or_what_is_asked_for(scenario):
    config = scenario(options='<begin value="5"/><end value="60"/>')
    assert [resolve_options(config, seed=1, begin_s=asked).begin_s for asked in (None, 0.0, 30.0)] == [5.0, 0.0, 30.0]
    assert value(resolve_options(config, seed=1, begin_s=30.25).arguments, "begin") == "30.25"
    with pytest.raises(GpsecError, match=r"traffic\.begin_s: expected less than the end in .*, 60 s, found 60 s"):
        resolve_options(config, seed=1, begin_s=60.0)


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("90", 90.0), ("0:1:30", 90.0), ("1:0:1:30", 86490.0), ("-1", None), ("", None)],
)
def test_end_is_read_in_every_notation(scenario, text, seconds):
    config = scenario(options=f'<begin value="10"/><end value="{text}"/>')
    options = resolve_options(config, seed=1)
    assert (options.begin_s, options.end_s) == (10.0, seconds)


@pytest.mark.parametrize(
    ("own", "routes", "asked", "metres"),
    [
        ("", "", None, 0.8),
        ('<lateral-resolution value="0.4"/>', "", None, 0.4),
        ('<lateral-resolution value="0.4"/>', "", 0.8, 0.8),
        ("", "", 0.0, 0.0),
        ('<lanechange.duration value="2"/>', "", None, 0.0),
        ("", '<vType id="a" laneChangeModel="LC2013"/>', None, 0.0),
        ("", '<vType id="a" laneChangeModel="SL2015"/>', None, 0.8),
    ],
)
def test_lateral_resolution(scenario, own, routes, asked, metres):
    config = scenario(routes=routes, options=own)
    options = resolve_options(config, seed=1, lateral_resolution_m=asked)
    assert options.lateral_resolution_m == metres
    assert value(options.arguments, "lateral-resolution") == (f"{metres:g}" if metres else None)


def test_lane_change_model_is_found_in_a_zipped_route_file(scenario):
    config = scenario()
    zipped = gzip.compress(b'<routes><vType id="a" laneChangeModel="DK2008"/></routes>')
    (config.parent / "cars.rou.xml").write_bytes(zipped)
    options = resolve_options(config, seed=1)
    assert options.lateral_resolution_m == 0.0
    assert any("cars.rou.xml uses lane-change model DK2008" in note for note in options.notes)


def test_what_only_the_gui_knows_is_ignored_and_noted(scenario):
    config = scenario(options='<gui_only><osg-view value="true"/><delay value="20"/></gui_only>')
    options = resolve_options(config, seed=1)
    assert "ignored (sumo-gui only): osg-view, delay" in options.notes
    assert not {"--osg-view", "--delay"} & set(options.arguments)


def test_outputs_logs_servers_and_random_seeds_are_left_out(scenario):
    dropped = ["tripinfo", "fcd-output", "log", "remote-port", "random", "output-prefix", "verbose"]
    config = scenario(options="".join(f'<{name} value="1"/>' for name in dropped))
    options = resolve_options(config, seed=1)
    names = {part for part in options.arguments if part.startswith("--")}
    assert not names & {f"--{name}" for name in [*dropped, "tripinfo-output"]}
    assert "outputs left out: tripinfo-output, fcd-output, log" in options.notes


def test_aliases_short_names_and_topics_make_no_difference(tmp_path, grid_net):
    config = tmp_path / "short.sumocfg"
    config.write_text(
        f'<configuration><n v="{grid_net}"/><time><e value="7"/></time><srand value="5"/></configuration>'
    )
    options = resolve_options(config, seed=2**31 + 3)
    assert options.net_file == grid_net
    assert options.end_s == 7.0
    assert value(options.arguments, "seed") == "3"  # the run's, modulo 2³¹
    assert options.arguments.count("--seed") == 1


@pytest.mark.parametrize("separator", [",", ", ", " ", ";"])
def test_lists_of_files_may_be_separated_as_in_any_version_of_sumo(scenario, separator):
    config = scenario()
    (config.parent / "b 1.rou.xml").write_text("<routes/>")
    (config.parent / "c.rou.xml").write_text("<routes/>")
    text = config.read_text().replace("cars.rou.xml", f"b%201.rou.xml{separator}c.rou.xml")
    config.write_text(text)
    routes = resolve_options(config, seed=1).route_files
    assert routes == (config.parent / "b 1.rou.xml", config.parent / "c.rou.xml")


@pytest.mark.parametrize(
    ("missing", "key"),
    [("grid.net.xml", "net-file"), ("cars.rou.xml", "route-files"), ("more.add.xml", "additional-files")],
)
def test_missing_input_is_named_with_its_key_and_the_nearest_file(scenario, missing, key):
    config = scenario()
    (config.parent / missing).rename(config.parent / missing.replace(".xml", "x.xml"))
    with pytest.raises(GpsecError) as raised:
        resolve_options(config, seed=1)
    assert str(raised.value).startswith(f"{config}: {key} names '{config.parent / missing}'")
    assert f"did you mean '{missing.replace('.xml', 'x.xml')}'?" in str(raised.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<configuration", "expected a SUMO configuration in XML"),
        ("<configuration/>", "expected the key 'net-file'"),
        ('<c><time><step-lenght value="1"/></time></c>', "'step-lenght' in <time> .* did you mean 'step-length'"),
        ('<c><end value="soon"/><end value="1"/></c>', "option 'end' is given twice"),
        ('<c><n value="grid.net.xml"/><end value="soon"/></c>', "option 'end': expected seconds or h:m:s"),
        ('<c><n value="grid.net.xml"/><mesosim value="true"/></c>', "expected a microscopic simulation"),
        ('<c><n value="run.sumocfg"/></c>', "expected <net version=…>, found <c>"),
        ('<c><n value="bare.xml"/></c>', "expected <net version=…>, found <net> without a version"),
        ('<c><n value="empty.xml"/></c>', "net-file .*empty.xml' is not readable as XML"),
    ],
)
def test_broken_configuration_is_one_sentence(scenario, content, message):
    config = scenario()
    (config.parent / "empty.xml").touch()
    (config.parent / "bare.xml").write_text("<net/>")  # libsumo crashes on it
    config.write_text(content)
    with pytest.raises(GpsecError, match=message) as raised:
        resolve_options(config, seed=1)
    assert str(config) in str(raised.value)


def test_configuration_that_is_not_there(tmp_path):
    (tmp_path / "town.sumocfg").touch()
    with pytest.raises(GpsecError, match=r"not found: did you mean 'town.sumocfg'\?"):
        resolve_options(tmp_path / "twon.sumocfg", seed=1)


@pytest.mark.parametrize("config", sorted(GAME.glob("*.sumocfg")), ids=lambda path: path.stem)
def test_every_scenario_of_the_wheel_resolves_to_options_of_sumo(config):
    options = resolve_options(config, seed=1)
    known = sumo_options_by_name()
    assert options.arguments[::2] == tuple(f"--{known[part[2:]].name}" for part in options.arguments[::2])
    assert not {known[part[2:]].topic for part in options.arguments[::2]} & {"output", "gui_only"}
    assert options.step_s in (0.05, 0.1)


def test_option_table_is_read_with_aliases_topics_and_kinds():
    table = parse_template(
        "<sumoConfiguration>\n    <input>\n        <!-- a -- comment <x> -->\n"
        '        <net-file value="" synonymes="n net" type="FILE"/>\n    </input>\n    <time>\n'
        '        <end value="-1" type="TIME"/>\n    </time>\n</sumoConfiguration>'
    )
    assert set(table) == {"net-file", "n", "net", "end"}
    assert table["n"] is table["net-file"]
    assert table["net"].is_file
    assert not table["end"].is_file
    assert (table["net"].topic, table["end"].topic, table["end"].default) == ("input", "time", "-1")


def test_variables_are_expanded_in_every_option_as_sumo_does_it(scenario, monkeypatch):
    monkeypatch.setenv("BEGIN", "7")
    monkeypatch.setenv("NETS", "grid")
    monkeypatch.delenv("NOTHING", raising=False)
    rest = '<begin value="${BEGIN}"/><end value="1${NOTHING}0:0"/><time-to-teleport value="${BEGIN}0"/>'
    config = scenario(options=rest.replace("0:0", ":0:${BEGIN}"))
    config.write_text(config.read_text().replace("grid.net.xml", "${NETS}.net${NOTHING}.xml"))
    options = resolve_options(config, seed=1)
    assert options.net_file == config.parent / "grid.net.xml"
    assert (options.begin_s, options.end_s) == (7.0, 3607.0)
    assert value(options.arguments, "time-to-teleport") == "70"


def test_what_only_looks_like_a_variable_is_left_alone(scenario, monkeypatch):
    monkeypatch.setenv("grid", "other")
    config = scenario()
    named = config.parent / "$grid.net.xml"
    (config.parent / "grid.net.xml").rename(named)
    config.write_text(config.read_text().replace("grid.net.xml", "$grid.net.xml"))
    assert resolve_options(config, seed=1).net_file == named


def test_home_stands_for_a_tilde(scenario, tmp_path, monkeypatch):
    config = scenario()
    monkeypatch.setenv("HOME", str(config.parent))
    moved = config.rename(tmp_path / "run.sumocfg")
    moved.write_text(moved.read_text().replace('value="', 'value="~/'))
    assert resolve_options(moved, seed=1).net_file == config.parent / "grid.net.xml"


def test_how_strictly_inputs_are_read_is_always_said(scenario):
    asked = '<report><xml-validation value="never"/><xml-validation.net value="always"/></report>'
    options = resolve_options(scenario(options=asked), seed=1)
    names = ("xml-validation", "xml-validation.net", "xml-validation.routes")
    assert [value(options.arguments, name) for name in names] == ["never", "local", "local"]
    assert any(note.startswith("xml-validation.net set to local") for note in options.notes)
