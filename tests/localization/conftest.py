import pytest

from gpsec.hdmap.map import HDMap
from gpsec.testing.rig import straight_road


@pytest.fixture(scope="session")
def straight() -> HDMap:
    """One lane of 5 km, due east along y = 0."""
    return straight_road()
