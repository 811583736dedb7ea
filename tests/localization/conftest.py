import pytest

from gpsec.hdmap.map import HDMap, compile_map


@pytest.fixture(scope="session")
def straight(plain_net) -> HDMap:
    """One lane of 5 km, due east along y = 0."""
    nodes = 'id="a" x="0" y="0"\nid="b" x="5000" y="0"'
    return compile_map(plain_net(nodes, 'id="ab" from="a" to="b" speed="30" spreadType="center"'), ())
