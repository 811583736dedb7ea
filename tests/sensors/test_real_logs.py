"""docs/sensors.md: figures of a profile stand beside those of real logs, and a difference has a reason."""

import re
from pathlib import Path

import pytest

from gpsec.sensors.registry import PROFILES

FACTOR = 2.0
PAGE = (Path(__file__).parents[2] / "docs" / "sensors.md").read_text("utf-8")
BLOCKS = re.findall(r"<!-- judged: (\w+) -->\n(.*?)<!-- end of judged -->", PAGE, re.DOTALL)
ROWS = [
    (name, *row)
    for name, block in BLOCKS
    for row in re.findall(r"^\| `(\w+)\.(\w+)` \| ([\d.]+) \| ([\d.]+) \| (.+?) \| ?(.*?) ?\|$", block, re.MULTILINE)
]


def test_there_is_something_to_judge():
    assert [name for name, _ in BLOCKS] == ["consumer"]
    assert len(ROWS) == len(re.findall(r"^\| `\w+\.\w+`", BLOCKS[0][1], re.MULTILINE)) > 5


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]}.{row[1]}.{row[2]}")
def test_what_differs_by_more_than_two_has_a_reason(row):
    name, channel, figure, says, measured, how, reason = row
    assert PROFILES[name].channels()[channel].figures()[figure] == float(says)
    assert how
    times = float(says) / float(measured)
    assert 1.0 / FACTOR <= times <= FACTOR or len(reason) > 10
