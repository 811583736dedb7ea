"""docs/terms.md: one meaning a term, two lines at most."""

import re
from collections import Counter
from pathlib import Path

PAGE = (Path(__file__).parents[1] / "docs" / "terms.md").read_text("utf-8")
ENTRIES = re.findall(r"^- (.+?)(?=\n- |\n\n|\Z)", PAGE, re.DOTALL | re.MULTILINE)
TERMS = Counter(name for entry in ENTRIES for name in re.match(r"\*\*(.+?)\*\*: ", entry)[1].lower().split(", "))


def test_a_term_has_one_meaning() -> None:
    assert [term for term, count in TERMS.items() if count > 1] == []


def test_a_meaning_has_two_lines_at_most() -> None:
    assert [entry for entry in ENTRIES if entry.count("\n") > 1 or len(entry) > 240] == []


def test_the_terms_of_the_tables_are_among_them() -> None:
    needed = ("track", "plan", "cell", "defence", "response", "world", "residual", "matching", "vehicle row", "event")
    assert {*needed, "onset", "delay", "false alarm", "outcome", "alarm", "sample"} <= set(TERMS)
