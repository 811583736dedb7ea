from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from gpsec.attacks.zones import zone_keys
from gpsec.pipeline import run as loop
from gpsec.pipeline.build import lay_ground
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.overrides import parse_set
from gpsec.traffic.recording import RecordedTraffic, Recording, record_traffic
from gpsec.traffic.session import SumoSession
from gpsec.types.drawn_zones import ATTACK_ZONE

DURATION_S = 45.0
# Early and short, so that attacks begin and end within the time that is simulated.
WHEN: dict[str, Any] = {"share": 0.6, "start_after_s": [0.0, 6.0], "duration_s": [4.0, 12.0]}
PLANS: dict[str, dict[str, Any]] = {
    "constant_bias": {"attack": "constant_bias", "bias_m": 2.4, **WHEN},
    "drift": {"attack": "drift", "rate_mps": 0.3, **WHEN},
    "noise": {"attack": "noise", "sigma_m": 3.0, **WHEN},
    "jamming": {"attack": "jamming", **WHEN},
}


@dataclass(frozen=True)
class Traffic:
    """Recorded traffic of a scenario: its fleet as the scenario draws it, and its drawn zones."""

    recording: Recording
    zones: list[Any]


@pytest.fixture(scope="session")
def town(repository: Path) -> Scenario:
    """The town for a short while, with plans that fit into it."""
    changes = {
        "duration_s": DURATION_S,
        "fleet.settle_s": 5.0,
        "fleet.equipped_share": 0.4,
        "outcomes.bootstrap": 50,
    }
    overrides = [parse_set(f"{key}={value}") for key, value in changes.items()]
    scenario = load_scenario(repository / "scenarios" / "town", overrides)
    return with_plans(scenario, PLANS)


def with_plans(scenario: Scenario, plans: dict[str, dict[str, Any]]) -> Scenario:
    raw = scenario.model_dump(mode="json") | {"plans": [{"name": name, **plan} for name, plan in plans.items()]}
    return Scenario.model_validate(raw)


@pytest.fixture(scope="session")
def traffic(town: Scenario) -> Traffic:
    ground = lay_ground(town)
    with SumoSession(ground.options, ground.hd_map.lane_index, ground.choice.equipped) as session:
        zones = session.zones({ATTACK_ZONE: zone_keys()})
        return Traffic(record_traffic(session, DURATION_S), zones)


@pytest.fixture
def replay(monkeypatch: pytest.MonkeyPatch) -> Callable[[Traffic], None]:
    """Return a function that puts recorded traffic in SUMO's place."""

    def use(traffic: Traffic) -> None:
        class ReplaySession(RecordedTraffic):
            warnings: Sequence[str] = ()
            traffic_only: dict[str, int] = {}  # noqa: RUF012

            def __init__(self, options: Any, lane_index: Any, equip: Any, controlled: bool = False) -> None:
                super().__init__(traffic.recording)
                self.options = options

            def __enter__(self) -> "ReplaySession":
                return self

            def __exit__(self, *error: object) -> None:
                self.close()

            def zones(self, known_keys: Any) -> list[Any]:
                return traffic.zones

        monkeypatch.setattr(loop, "RemoteSession", ReplaySession)

    return use


Run = Callable[..., Path]


@pytest.fixture
def go(tmp_path: Path) -> Run:
    """Return a function that runs a scenario into a new folder and gives it."""

    def run(scenario: Scenario) -> Path:
        folder = tmp_path / f"run{len(list(tmp_path.iterdir()))}"
        folder.mkdir()
        loop.run_scenario(scenario, folder, lambda progress: None)
        return folder

    return run
