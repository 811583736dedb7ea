"""`--rates` gives every defence every rate, once."""

import pytest

from gpsec.core.errors import GpsecError
from gpsec.scenario import load_scenario
from gpsec.scenario.rates import with_rates


@pytest.fixture(scope="module")
def town(repository):
    return load_scenario(repository / "scenarios" / "town")


def test_every_defence_has_every_rate_once(town):
    found = with_rates(town, ["0.1/h", "1/h", "0.1/h"])
    names = [defence.name for defence in found.defences]
    assert names[:2] == ["never+none", "told+ukf"]
    assert len(names) == len(set(names))
    # lstm_glr+ukf is there at two rates before, and at two others after.
    assert [name for name in names if name.startswith("lstm_glr") and name.endswith("+ukf")] == [
        "lstm_glr+ukf",
        "lstm_glr@1/h+ukf",
    ]
    assert "joint@1/h+ukf5_rollback" in names
    assert found.detection.rates == ("0.1/h", "1/h")
    assert {rate for name, rate in found.points() if name == "cusum"} == {"0.1/h", "1/h"}


def test_an_unknown_rate_is_refused(town):
    with pytest.raises(GpsecError, match=r"--rates: unknown false-alarm rate '2/h'"):
        with_rates(town, ["2/h"])
