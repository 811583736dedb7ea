"""Change what is in order: bytes, words, XML, JSON, CSV, arrays. Everything is drawn from the generator given."""

import copy
import csv
import io
import json
import zipfile
import zlib
from collections.abc import Callable
from random import Random
from typing import Any
from xml.etree import ElementTree

import numpy as np

NUMBERS = (
    *("-1", "0", "-0", "1", "2", "255", "65536", "1e308", "-1e308", "1e-320", "nan", "inf", "-inf", "0x10", "1_000"),
    *("2147483647", "2147483648", "-2147483649", "9223372036854775807", "1073741824", "1e6", "0.1", "1e400", "99999"),
)
WORDS = (
    *("", " ", "x" * 5000, "../" * 40, "\u202eexe", "\x1b[2J", "a\nb", "'", '"', "<b>", "&amp;", "#2", "p#2", "=1+1"),
    *("true", "false", "none", "${HOME}", "%s", "{}", "é", "\u0000", "\ufeff", "localhost:1", "/dev/null", "nul", ","),
)
Mutate = Callable[[bytes, Random], bytes]


def anything(data: bytes, draw: Random) -> bytes:
    """Damage bytes: a flipped bit, a piece cut out, doubled, moved or put in, the end cut off."""
    if not data:
        return draw.randbytes(draw.randrange(1, 40))
    at, size = draw.randrange(len(data)), draw.choice((1, 2, 8, 64, 1024))
    piece = data[at : at + size]
    kind = draw.randrange(6)
    if kind == 0:
        return data[:at] + bytes([data[at] ^ 1 << draw.randrange(8)]) + data[at + 1 :]
    if kind == 1:
        return data[:at] + data[at + size :]
    if kind == 2:
        return data[:at] + piece + data[at:]
    if kind == 3:
        to = draw.randrange(len(data))
        return data[:to] + piece + data[to:]
    if kind == 4:
        put = draw.choice((b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"<", b"&", draw.randbytes(size)))
        return data[:at] + put + data[at:]
    return data[:at]


def words(data: bytes, draw: Random) -> bytes:
    """Change a text of words, numbers and lines, such as TOML."""
    lines = data.decode("utf-8", "replace").split("\n")
    at = draw.randrange(len(lines))
    kind = draw.randrange(5)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(draw.randrange(len(lines) + 1), lines[at])
    else:
        parts = lines[at].split(" ")
        parts[draw.randrange(len(parts))] = value(draw) if kind < 4 else json.dumps(value(draw))
        lines[at] = " ".join(parts)
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def value(draw: Random) -> str:
    """Return a number or a word that is seldom expected."""
    return draw.choice(draw.choice((NUMBERS, WORDS)))


def xml(data: bytes, draw: Random) -> bytes:
    """Change a tree of XML; bytes where it is none."""
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError:
        return anything(data, draw)
    parents = {child: parent for parent in root.iter() for child in parent}
    if not parents:
        return anything(data, draw)
    chosen = draw.choice(list(parents))
    kind = draw.randrange(8)
    if kind == 0:
        parents[chosen].remove(chosen)
    elif kind == 1:
        parents[chosen].insert(draw.randrange(len(parents[chosen]) + 1), chosen)
    elif kind == 2:
        draw.choice([root, *parents]).append(copy.deepcopy(chosen))
    elif kind == 3:
        chosen.tag = draw.choice([*parents]).tag
    elif kind == 4:
        chosen.text = value(draw)
    elif chosen.attrib:
        key = draw.choice(list(chosen.attrib))
        if kind == 5:
            del chosen.attrib[key]
        else:
            other = draw.choice([*parents]).attrib
            chosen.set(key, draw.choice((value(draw), value(draw), *other.values())))
    made = ElementTree.tostring(root, "unicode").encode("utf-8", "surrogatepass")
    # Control characters cannot stand in XML: as references they reach the parser, as bytes they end it early.
    return made.replace(b"\0", b"&#0;") if draw.random() < 0.5 else made


def json_(data: bytes, draw: Random) -> bytes:
    """Change a value of a JSON document, or take one out."""
    try:
        document = json.loads(data)
    except ValueError:
        return anything(data, draw)
    holders = list(_holders(document))
    if not holders:
        return anything(data, draw)
    holder, key = draw.choice(holders)
    if draw.random() < 0.3:
        del holder[key]
    else:
        others = (None, True, -1, 0, 1e308, 2**64, [], {}, [[]], value(draw), holders[0][0])
        holder[key] = draw.choice([*others[:10], json.loads(json.dumps(draw.choice(holders)[0]))])
    return json.dumps(document).encode()


def _holders(node: Any) -> Any:
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, below in items:
        yield node, key
        yield from _holders(below)


def table(data: bytes, draw: Random) -> bytes:
    """Change a CSV table: a cell, a column, a row, the header."""
    rows = list(csv.reader(io.StringIO(data.decode("utf-8", "replace"), newline=None)))
    if not rows or not rows[0]:
        return anything(data, draw)
    row, column = draw.randrange(len(rows)), draw.randrange(len(rows[0]))
    kind = draw.randrange(5)
    if kind == 0 and column < len(rows[row]):
        rows[row][column] = value(draw).replace("\0", "")
    elif kind == 1:
        rows = [[cell for at, cell in enumerate(cells) if at != column] for cells in rows]
    elif kind == 2:
        rows[row] = rows[row][:column]
    elif kind == 3:
        rows[0][column] = value(draw).replace("\0", "")
    else:
        del rows[row]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode("utf-8", "surrogatepass")


def arrays(data: bytes, draw: Random) -> bytes:
    """Change an array of an ``.npz`` file: its values, type, shape, name; or its bytes."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as stored:
            held = {name: stored[name] for name in stored.files}
    except (ValueError, OSError, zipfile.BadZipFile, zlib.error, EOFError):
        return anything(data, draw)
    name = draw.choice(list(held))
    kind = draw.randrange(7)
    if kind == 0:
        del held[name]
    elif kind == 1:
        wanted = draw.choice((np.float32, np.int8, np.int64, np.str_))
        held[name] = held[name].astype(wanted if held[name].dtype.kind in "biuf" else np.bytes_, casting="unsafe")
    elif kind == 2:
        held[name] = held[name][: draw.randrange(len(held[name]) + 1)] if held[name].ndim else held[name][None]
    elif kind == 3:
        held[name] = held[draw.choice(list(held))]
    elif kind < 6 and held[name].size:
        flat = held[name].copy().reshape(-1)
        numbers = (-1, 0, 1, 2**30, -(2**31), 10**6, np.nan, np.inf, 1e308)
        with np.errstate(all="ignore"):
            flat[draw.randrange(flat.size)] = np.asarray(draw.choice(numbers)).astype(flat.dtype)
        held[name] = flat.reshape(held[name].shape)
    stream = io.BytesIO()
    np.savez(stream, **held)  # type: ignore[arg-type]
    return anything(stream.getvalue(), draw) if kind == 6 else stream.getvalue()


def several(mutate: Mutate, data: bytes, draw: Random) -> bytes:
    """Change something once or a few times; now and then as bytes."""
    for _ in range(draw.choice((1, 1, 1, 2, 4))):
        data = (anything if draw.random() < 0.15 else mutate)(data, draw)
    return data
