import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
import sumo
from hypothesis import settings

# A shell lets what it starts in the background ignore Ctrl-C, and so would the programs under test.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# The same examples on every machine and in every run.
settings.register_profile("reproducible", derandomize=True, deadline=None, database=None)
settings.load_profile("reproducible")

PlainNet = Callable[..., Path]


@pytest.fixture(scope="session")
def repository() -> Path:
    return Path(__file__).parents[1]


@pytest.fixture(scope="session")
def plain_net(tmp_path_factory: pytest.TempPathFactory) -> PlainNet:
    """Return a function that makes a net of plain XML: the attributes of nodes and edges, and options of netconvert."""
    program = Path(sumo.SUMO_HOME) / "bin" / "netconvert"

    def make(nodes: str, edges: str, *options: str, connections: str = "", turnarounds: bool = False) -> Path:
        folder = tmp_path_factory.mktemp("net")
        inputs = []
        for kind, content in (("node", nodes), ("edge", edges), ("connection", connections)):
            if content:
                lines = "\n".join(f"<{kind} {line}/>" for line in content.strip().splitlines())
                (folder / f"plain.{kind[:3]}.xml").write_text(f"<{kind}s>\n{lines}\n</{kind}s>")
                inputs += [f"--{kind}-files", f"plain.{kind[:3]}.xml"]
        fixed = ["--offset.disable-normalization", "--precision", "6", "-o", "made.net.xml"]
        if not turnarounds:
            fixed.append("--no-turnarounds")
        subprocess.run([program, *inputs, *fixed, *options], cwd=folder, check=True, capture_output=True)
        return folder / "made.net.xml"

    return make
