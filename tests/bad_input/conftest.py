import subprocess
from pathlib import Path

import pytest
import sumo


@pytest.fixture(scope="session")
def grid(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The text of a net of 3 × 3 junctions, A0 … C2."""
    net = tmp_path_factory.mktemp("grid") / "grid.net.xml"
    program = Path(sumo.SUMO_HOME) / "bin" / "netgenerate"
    shape = ["--grid", "--grid.number=3", "--grid.length=200", "--default.lanenumber=2", "--no-turnarounds"]
    subprocess.run([program, *shape, "-o", net], check=True, capture_output=True)
    return net.read_text()


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path
