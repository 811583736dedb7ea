import os

import pytest

from gpsec.traffic.stderr import CaughtStderr, input_warnings, sumo_words


@pytest.mark.parametrize(
    ("printed", "raised", "words"),
    [
        ("Error: No net.\nQuitting (on error).\n", "Process Error", "No net"),
        (
            "Warning: w\nError: broken\n In file 'a'\n At line/column 3/4.\n\n",
            "Process Error",
            "broken In file 'a' At line/column 3/4",
        ),
        ("", "Vehicle 'q' has no valid route.\n", "Vehicle 'q' has no valid route"),
        ("Error: a\nError: a\nError: b\n", "Process Error", "a; b"),
        ("", "Process Error", "Process Error"),
        ("", "", "no reason given"),
    ],
)
def test_words_are_the_errors_alone_in_one_line(printed, raised, words):
    assert sumo_words(printed, raised) == words


def test_what_is_printed_below_python_is_caught_until_the_end(capfd):
    caught = CaughtStderr()
    for round_ in ("one", "two"):
        with caught:
            os.write(2, round_.encode())
        assert caught.text() == round_
    os.write(2, b"open")
    caught.close()
    assert capfd.readouterr().err == "open"


def test_warnings_of_the_input_are_told_once_a_kind():
    log = [
        "Warning: Invalid characters for Poly ID 'old town'",
        "Warning: Vehicle 'a' performs emergency braking on lane 'ab_0', time=3.00.",
        "Warning: Missing yellow phase in tlLogic 'J1', program '0' for tl-index 4.",
        " In file 'n.net.xml'",
        "Warning: Invalid characters for Poly ID 'a<b'",
        "Warning: Missing yellow phase in tlLogic 'J2', program '0' for tl-index 17.",
        " In file 'n.net.xml'",
        "Warning: 21 total messages of type: Vehicle '%' performs emergency braking on lane '%', time=%.",
        "Warning: 14 total messages of type: Invalid characters for Poly ID '%'",
    ]
    assert input_warnings(log) == [
        "SUMO warns: Invalid characters for Poly ID 'old town' (14 of this kind)",
        "SUMO warns: Missing yellow phase in tlLogic 'J1', program '0' for tl-index 4. In file 'n.net.xml'"
        " (2 of this kind)",
    ]


def test_no_more_than_ten_kinds_of_warnings_are_told():
    said = input_warnings([f"Warning: {letter * 3}" for letter in "abcdefghijklm"])
    assert len(said) == 11
    assert said[-1] == "3 more kinds of warnings are in manifest.json"


def test_a_log_without_warnings_says_nothing():
    assert input_warnings([]) == []
