"""What a sentence echoes of a file neither floods nor steers the terminal."""

import io
import pickle

import pytest
from rich.table import Table
from rich.text import Text

from gpsec.console.bars import Bars
from gpsec.console.errors import complain, say
from gpsec.console.terminal import Terminal, status
from gpsec.core.errors import GpsecError, nearest, printable, retold, shown
from gpsec.core.progress import Progress

# Sets the colour, goes back in the line, ends the string of a title, turns the direction of reading, no character.
STEERING = "\x1b[31m", "\r", "\x9c", "\u202e", "\u2066", "\udc80", "\x00", "\u2028"


@pytest.mark.parametrize("sign", STEERING)
def test_nothing_in_a_value_steers_the_terminal(sign: str) -> None:
    assert shown(f"a{sign}b").isprintable()
    assert shown(f"a{sign}b").startswith("a\\")


def test_what_prints_stays_as_it_is() -> None:
    assert shown("Straße №7 – 北 'x'") == "Straße №7 – 北 'x'"


@pytest.mark.parametrize("value", ["x" * 101, "\x1b" * 100, "y" * 10**6, "\u202e" * 99])
def test_a_value_has_at_most_100_characters(value: str) -> None:
    assert len(shown(value)) == 100
    assert "…" in shown(value)


def test_beginning_and_end_of_a_long_value_are_shown() -> None:
    assert shown("a" * 60 + "b" * 1000 + "c" * 39) == "a" * 60 + "…" + "c" * 39


def test_100_characters_are_shown_whole() -> None:
    assert shown("x" * 100) == "x" * 100


def test_an_error_is_one_printable_line_also_from_another_process() -> None:
    error = GpsecError("a\x1b]0;owned\x07\n   b")
    assert str(error) == "a\\x1b]0;owned\\x07 b"
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_choices_are_shown_cut_short_and_not_all() -> None:
    said = nearest("x", [f"{'n' * 200}{number}" for number in range(1000)])
    assert len(said) < 60 * 103


def test_words_of_another_program_are_cut_short() -> None:
    said = retold(f"Unknown type '{'t' * 5000}'\n  at line 3;  \x1b[2J" + "w" * 5000)
    assert said.startswith(f"Unknown type '{shown('t' * 5000)}' at line 3; \\x1b[2J")
    assert len(said) <= 1001


@pytest.mark.parametrize("sign", [*STEERING[:-1]])
def test_nothing_in_tables_and_notes_steers_the_terminal(sign: str) -> None:
    out = io.StringIO()
    console = Terminal(file=out, width=60)
    table = Table("vehicle", "what")
    table.add_row(f"car{sign}1", Text(f"{sign}gone"))
    console.print(table)
    console.print(f"note: {sign}", markup=False)
    lines = out.getvalue().split("\n")
    assert len(lines) == 7
    assert all(line.isprintable() for line in lines)
    assert f"car{shown(sign)}1" in out.getvalue()


def test_what_rich_draws_itself_is_not_escaped() -> None:
    out = io.StringIO()
    Terminal(file=out, force_terminal=True, color_system="standard", _environ={}).print(Text("a\x1b[2J", style="bold"))
    assert out.getvalue() == "\x1b[1ma\\x1b[2J\x1b[0m\n"


@pytest.mark.parametrize("name", ["[bold]a[/bold]", "[/x]", "a[red]", ":car:"])
def test_names_are_no_markup(name: str) -> None:
    out = io.StringIO()
    console = Terminal(file=out, width=60, force_terminal=True, emoji=False, _environ={"TERM": "dumb"})
    table = Table("plan")
    table.add_row(name)
    console.print(table)
    with status(console, f"{name}: ") as tell:
        tell("reading")
    with Bars(console, 1) as bars:
        bars(Progress(name, note=name))
    assert out.getvalue().count(name) > 2


def test_lines_for_the_user_are_escaped(capsys: pytest.CaptureFixture[str]) -> None:
    say("a\x1bb")
    assert complain(GpsecError("c\x1b\nd")) == 2
    told = capsys.readouterr()
    assert told.out == "a\\x1bb\n"
    assert told.err == "gpsec: error: c\\x1b d\n"


def test_printable_keeps_printable_text() -> None:
    assert printable("µs – ok") == "µs – ok"
