"""Rates of events against twins, by hand."""

import pandas as pd
import pytest

from benchmarks.event_rates import KINDS, event_rates


def world(seed: int, plan: str, collisions: int, km: float) -> dict[str, object]:
    """Return a world whose vehicles drove at 10 m/s: 36 km are a vehicle-hour."""
    head = {"scenario": f"town-world-00-seed-{seed}", "seed": seed, "plan": plan, "defence": "never+none"}
    counts = dict.fromkeys(KINDS, 0) | {"collisions": collisions}
    return head | {"on_alarm": "stop", "false_alarms_per_h": 0.0, "vehicle_km": km, "mean_speed_mps": 10.0} | counts


def test_rates_are_of_sums_and_seeds_are_drawn_in_pairs() -> None:
    """Seeds 1 and 2: 3 and 1 collisions in 100 and 300 km, none and 1 in 100 km each of the twins."""
    rows = [world(1, "stealth", 3, 100.0), world(2, "stealth", 1, 300.0)]
    rows += [world(1, "none", 0, 100.0), world(2, "none", 1, 100.0), world(3, "stealth", 50, 1.0)]
    found = event_rates(pd.DataFrame(rows)).set_index("kind").loc["collisions"]
    assert (found["seeds"], found["events"], found["twin_events"]) == (2, 4, 1)
    assert found["per_1000_vkm"] == pytest.approx(4 / 0.4 - 1 / 0.2)
    assert found["per_vehicle_hour"] == pytest.approx(4 / (400 / 36) - 1 / (200 / 36))
    # Seed 1 alone, both, or seed 2 alone, with probabilities of a quarter, a half and a quarter.
    assert found["per_1000_vkm_low"] == pytest.approx(1 / 0.3 - 1 / 0.1)
    assert found["per_1000_vkm_high"] == pytest.approx(3 / 0.1)


def test_one_seed_has_no_interval() -> None:
    found = event_rates(pd.DataFrame([world(1, "stealth", 2, 100.0), world(1, "none", 0, 100.0)]))
    assert found["per_1000_vkm"].max() == pytest.approx(20.0)
    assert found["per_1000_vkm_low"].isna().all()
