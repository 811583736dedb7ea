"""The tapes that gpsec comes with: rendered by it, on networks that no result is reported on."""

import numpy as np
import pytest

from gpsec.sensors.shipped_tapes import load_tape, shipped_tapes

TAPES = [name for name in shipped_tapes() if name.startswith("rendered-")]


def test_there_is_one_for_each_weather():
    assert [f"rendered-{weather}" for weather in ("good", "night", "rain", "worn")] == TAPES


@pytest.mark.parametrize("name", TAPES)
def test_it_says_what_it_is_of(name):
    tape, _ = load_tape(name)
    assert (tape.kind, tape.rate_hz) == ("camera", 10.0)
    assert f"rendered-{tape.condition}" == name
    assert set(tape.provenance["scenarios"]) == {"beltway", "mountain", "suburb"}
    assert "image measure" in tape.provenance["made_by"]
    assert len(tape.missing) > 1000


def test_worn_paint_is_lost_more_often_and_nothing_is_a_lane_away():
    good, worn = load_tape("rendered-good")[0], load_tape("rendered-worn")[0]
    assert worn.missing.mean() > 1.5 * good.missing.mean()
    assert np.abs(good.errors[:, 0]).max() < 1.5
