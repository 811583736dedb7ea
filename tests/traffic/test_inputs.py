import gzip

import pytest

from gpsec.traffic.inputs import OwnParameter, first_match, own_parameters

CONTENT = (
    '<additional><poly id="z" type="gpsec.attack"><param key="gpsec.share" value="1"/>'
    '<param key="other" value="2"/></poly>'
    '<vTypeDistribution id="d"><vType id="car"><param value="0.5" key="gpsec.equipped"/></vType></vTypeDistribution>'
    "</additional>"
)


@pytest.mark.parametrize("pack", [lambda content: content, gzip.compress])
def test_own_parameters_come_with_their_owner(tmp_path, pack):
    path = tmp_path / "more.add.xml"
    path.write_bytes(pack(CONTENT.encode()))
    assert list(own_parameters(path)) == [
        OwnParameter(path, "poly", "z", "gpsec.attack", "gpsec.share", "1"),
        OwnParameter(path, "vType", "car", "", "gpsec.equipped", "0.5"),
    ]


def test_what_a_file_includes_belongs_to_it(tmp_path):
    (tmp_path / "more.add.xml").write_text(CONTENT)
    (tmp_path / "all.add.xml").write_text('<additional><include href="more.add.xml"/></additional>')
    assert [(found.file.name, found.key) for found in own_parameters(tmp_path / "all.add.xml")] == [
        ("more.add.xml", "gpsec.share"),
        ("more.add.xml", "gpsec.equipped"),
    ]


def test_a_file_that_has_changed_is_read_again(tmp_path):
    path = tmp_path / "more.add.xml"
    path.write_text(CONTENT)
    assert len(own_parameters(path)) == 2
    path.write_text("<additional/>")
    assert own_parameters(path) == ()


def test_broken_file_yields_what_can_be_read(tmp_path):
    path = tmp_path / "more.add.xml"
    path.write_text(CONTENT[:-30])
    assert [found.key for found in own_parameters(path)] == ["gpsec.share", "gpsec.equipped"]


def test_match_across_the_border_of_what_is_read_at_once(tmp_path):
    path = tmp_path / "big.rou.xml"
    for before in range((1 << 22) - 4, (1 << 22) + 1):
        path.write_bytes(b" " * before + b'key="LC2013"')
        assert first_match(path, rb'key="(LC\d+)"') == "LC2013"
    assert first_match(path, rb'key="(SL\d+)"') == ""


@pytest.mark.parametrize("encoding", ["utf-16", "iso-8859-1"])
def test_parameters_in_any_encoding(tmp_path, encoding):
    path = tmp_path / "more.add.xml"
    path.write_bytes(f'<?xml version="1.0" encoding="{encoding}"?>{CONTENT}'.encode(encoding))
    assert [found.key for found in own_parameters(path)] == ["gpsec.share", "gpsec.equipped"]


def test_files_that_include_each_other_are_read_once(tmp_path):
    more = '<additional><include href="b.xml"/><tazs><include href="c.xml"/><include href="c.xml"/></tazs></additional>'
    (tmp_path / "a.xml").write_text(more)
    (tmp_path / "b.xml").write_text(f'<additional><include href="./a.xml"/>{CONTENT}</additional>')
    (tmp_path / "c.xml").write_text(CONTENT.replace('"z"', '"y"'))
    found = own_parameters(tmp_path / "a.xml")
    assert [(one.file.name, one.owner_id) for one in found] == [
        ("b.xml", "z"),
        ("b.xml", "car"),
        ("c.xml", "y"),
        ("c.xml", "car"),
    ]


def test_an_included_file_that_has_changed_is_read_again(tmp_path):
    (tmp_path / "a.xml").write_text('<additional><include href="b.xml"/></additional>')
    assert own_parameters(tmp_path / "a.xml") == ()
    (tmp_path / "b.xml").write_text(CONTENT)
    assert len(own_parameters(tmp_path / "a.xml")) == 2
