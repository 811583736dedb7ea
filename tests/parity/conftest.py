import pytest

from .drive import Drive, record_drive


@pytest.fixture(scope="session", params=["town", "sharp_turns"])
def drive(request: pytest.FixtureRequest) -> Drive:
    """Real traffic of a scenario, recorded once."""
    return record_drive(request.param, duration_s=30.0)
