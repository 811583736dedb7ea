"""The example in docs/adding-a-reaction.md is a reaction that works."""

import re
from pathlib import Path

import numpy as np

from gpsec.scenario import parts
from gpsec.steering.base import Follow, Situation
from gpsec.steering.registry import REACTIONS
from gpsec.testing import check_reaction

GUIDE = (Path(__file__).parents[2] / "docs" / "adding-a-reaction.md").read_text(encoding="utf-8")


def test_the_example_crawls_and_keeps_the_contract(tmp_path, monkeypatch):
    for of in ("_parts", "_modules"):
        monkeypatch.setattr(REACTIONS, of, dict(getattr(REACTIONS, of)))
    monkeypatch.setattr(parts, "_used", {})
    found = re.search(r"```python\n(.*?)```", GUIDE, re.DOTALL)
    assert found
    (tmp_path / "crawl.py").write_text(found[1], encoding="utf-8")
    parts.use([f"{tmp_path / 'crawl.py'}:Crawl"])
    check_reaction(REACTIONS["crawl"])
    rows, key = np.arange(3, dtype=np.int32), np.ones(3, np.uint64)
    alarm, speed = np.array([True, True, False]), np.array([9.0, 3.0, 9.0])
    conduct = REACTIONS["crawl"]().apply(Situation(rows, key, 0, 0.1, alarm, speed), None)
    assert conduct.follow.tolist() == [Follow.LANE, Follow.LANE, Follow.ESTIMATE]
    assert conduct.brake_mps2.tolist() == [1.5, 0.0, 0.0]
