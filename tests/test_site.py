"""The documentation site builds without a warning, and its links stay inside it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("material")


@pytest.fixture(scope="module")
def site(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(command, cwd=repository, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def test_pages_of_the_repository_and_of_the_code_are_there(site: Path) -> None:
    for page in ("index.html", "results/index.html", "parts/index.html", "api/index.html", "analysis/index.html"):
        assert (site / page).is_file()
    parts = (site / "parts" / "index.html").read_text("utf-8")
    assert "constant_bias" in parts
    assert "rate_mps = 0.2" in parts
    assert "Return the results in a folder" in (site / "api" / "index.html").read_text("utf-8")


def test_links_lead_to_pages(site: Path) -> None:
    for path in site.rglob("*.html"):
        for link in re.findall(r'<a [^>]*href="([^"#:]+\.html|[^"#:]+/)(?:#[^"]*)?"', path.read_text("utf-8")):
            target = (path.parent / link).resolve()
            if link.startswith("/"):
                continue  # of the page that is shown for missing ones
            assert target.is_file() or (target / "index.html").is_file(), (path, link)
