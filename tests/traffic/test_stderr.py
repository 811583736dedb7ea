import os

import pytest

from gpsec.traffic.stderr import CaughtStderr, sumo_words


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
