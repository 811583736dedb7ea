import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.paper import pinning, pool
from gpsec.paper.design import (
    PIN_DELTAS,
    SET_UPS,
    target_m,
)


def test_the_crossing_is_interpolated():
    # 1.3 -> 1.0 s, 1.4 -> 0.6 s: 0.8 s lies in the middle.
    delays_s = [2.0, 1.5, 1.0, 0.6, 0.5, 0.4, 0.3]
    assert PIN_DELTAS[2:4] == (1.3, 1.4)
    assert pinning._crossing("dsd", delays_s, 0.8) == 1.35
    with pytest.raises(GpsecError, match=r"isolation_forest takes 2\.00 s .* 'dsd': expected 0\.2 s"):
        pinning._crossing("dsd", delays_s, 0.2)


def test_the_paper_s_undefended_error():
    assert target_m("dsd") == pytest.approx(2.16, abs=0.01)  # √(1.52² + 1.54²), as its table says
    assert target_m("carla") == pytest.approx(3.387, abs=0.001)  # √(2.41² + 2.38²), where its table says 4.789
    assert target_m("nuscenes") == pytest.approx(2.908, abs=0.002)


def test_delta_and_bias_follow_from_the_training_runs(monkeypatch):
    delays_s = dict(zip(PIN_DELTAS, [2.0, 1.5, 1.0, 0.6, 0.5, 0.4, 0.3], strict=True))
    rows = []
    for profile in SET_UPS:
        common = {"profile": profile, "run": "r", "vehicle_id": "v", "attack_seconds": 10.0}
        common |= dict.fromkeys((*pool.ERRORS, *pool.LARGEST), 0.9 * target_m(profile))
        rows += [
            common
            | {
                "attack": f"stealth_{delta:g}",
                "detector": pinning.ANCHOR,
                "response": "ukf",
                "detection_delay_s": delay_s,
            }
            for delta, delay_s in delays_s.items()
        ]
        rows.append(common | {"attack": f"constant_{profile}", "detector": "never", "defence": "never+none"})
    monkeypatch.setattr(pool, "read_runs", lambda runs, table: pd.DataFrame(rows))
    pinned = pinning.pin([])
    assert pinned.delta == dict.fromkeys(SET_UPS, 1.35)
    # A bias of the target's size left nine tenths of it.
    assert pinned.bias_m["dsd"] == pytest.approx(target_m("dsd") / 0.9, abs=0.005)
