import pytest

from .drive import Drive, record_drive


@pytest.fixture(scope="session", params=["town", "sharp_turns"])
def drive(request: pytest.FixtureRequest) -> Drive:
    """Real traffic of a scenario, recorded once."""
    return record_drive(request.param, duration_s=30.0)


@pytest.fixture(scope="session")
def short_steps() -> Drive:
    """Traffic at a step in which hardly ever both a fix and a camera sample come."""
    return record_drive("town", 12.0, 0.025, ("carla", "nuscenes", "consumer"))
