"""The files that a scenario reads, and those that its files name."""

import gzip
from pathlib import Path

import pytest

from gpsec.traffic.input_files import FileReference, input_files, references


def names(*paths: Path) -> list[str]:
    return [path.name for path in input_files(paths)]


def test_all_that_is_read_in_the_order_of_reading(tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    (tmp_path / "a.xml").write_text(
        '<additional><include href="more/b.xml"/><edgeData id="e" file="written.xml" edgesFile="edges.txt"/>'
        '<rerouter id="r" edges="x" file="r.xml"/><variableSpeedSign id="v" lanes="x" file="v.xml"/>'
        '<calibrator id="c" file="c.xml" output="written.xml"/><poi id="p" imgFile="written.xml"/></additional>'
    )
    (tmp_path / "more" / "b.xml").write_text('<additional><x><include href="d.xml"/></x></additional>')
    (tmp_path / "more" / "d.xml").write_bytes(gzip.compress(b'<additional><include href="../last.xml"/></additional>'))
    for name in ("last.xml", "r.xml", "v.xml", "c.xml", "edges.txt", "written.xml", "z.xml"):
        (tmp_path / name).write_text("<additional/>")
    expected = ["a.xml", "b.xml", "d.xml", "last.xml", "edges.txt", "r.xml", "v.xml", "c.xml", "z.xml"]
    assert names(tmp_path / "a.xml", tmp_path / "z.xml") == expected


def test_files_that_include_each_other(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text('<additional><include href="b.xml"/><include href="a.xml"/></additional>')
    (tmp_path / "b.xml").write_text('<additional><include href="./a.xml"/><include href="gone.xml"/></additional>')
    assert names(tmp_path / "a.xml") == ["a.xml", "b.xml"]


def test_parameters_name_files_too(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    path.write_text(
        '<routes><vType id="t"><param key="device.ssm.file" value="host:80"/><param key="profile" value="x"/></vType>'
        '<vType id="u"><param key="device.ssm.&#102;ile" value="o.xml"/></vType></routes>'
    )
    assert references(path) == (
        FileReference(path, "param", "device.ssm.file", "host:80", False),
        FileReference(path, "param", "device.ssm.file", "o.xml", False),
    )


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-be", "iso-8859-1"])
def test_names_are_seen_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "a.xml"
    stated = encoding.removesuffix("-be")
    path.write_bytes(f'<?xml version="1.0" encoding="{stated}"?>\n<a><include href="ü.xml"/></a>'.encode(encoding))
    assert [found.value for found in references(path)] == ["ü.xml"]


@pytest.mark.parametrize("value", ["x" * 5000, "", "  ", ".", "a:80"])
def test_names_that_are_no_files(tmp_path: Path, value: str) -> None:
    path = tmp_path / "a.xml"
    path.write_text(f'<a><include href="{value}"/></a>')
    assert names(path) == ["a.xml"]


def test_what_a_broken_file_names_before_its_fault(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    path.write_text('<a><include href="b.xml"/><include href="c.xml"')
    assert [found.value for found in references(path)] == ["b.xml"]
    path.write_bytes(b"\x1f\x8bnot gzipped")
    assert references(path) == ()
    assert references(tmp_path / "gone.xml") == ()


def test_entities_do_not_grow_without_end(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    grown = "".join(f'<!ENTITY e{n} "{f"&e{n - 1};" * 10}">' for n in range(1, 12))
    path.write_text(f"<!DOCTYPE a [<!ENTITY e0 \"<include href='b.xml'/>\">{grown}]><a>&e11;</a>")
    assert len(references(path)) < 1e6
