"""What `make docs` adds to the pages in docs/: those that lie elsewhere, and those that are made from the code."""

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
# Pages of the site -> where they lie in the repository.
ELSEWHERE = {
    "index.md": "README.md",
    "results.md": "results/README.md",
    "scenarios.md": "scenarios/README.md",
    "contributing.md": "CONTRIBUTING.md",
    "security.md": "SECURITY.md",
    "changelog.md": "CHANGELOG.md",
}
_PAGE_OF = {source: page for page, source in ELSEWHERE.items()}
_KINDS = ("attacks", "detectors", "responses", "profiles")
# What is meant to be called from Python.
_MODULES = (
    "gpsec.running.api",
    "gpsec.running.checking",
    "gpsec.running.results",
    "gpsec.training.train_models",
    "gpsec.training.pool",
    "gpsec.report.make",
    "gpsec.testing",
    "gpsec.attacks.base",
    "gpsec.detection.base",
    "gpsec.detection.families",
    "gpsec.detection.plain",
    "gpsec.localization.responses",
    "gpsec.sensors.profiles",
)
_LINK = re.compile(r"\]\(([^)#:\s]+)(#[^)\s]*)?\)")


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that are not in docs/."""
    made = {page: (ROOT / source).read_text("utf-8") for page, source in ELSEWHERE.items()}
    made |= {"parts.md": _parts(), "api.md": _api()}
    for page, text in made.items():
        files.append(File.generated(config, page, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, **others: Any) -> str:
    """Let links go to pages of the site; what has none is named without a link."""
    source = ELSEWHERE.get(page.file.src_path, f"docs/{page.file.src_path}")
    folder = posixpath.dirname(source)

    def mended(found: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(folder, found[1]))
        inside = _PAGE_OF.get(target) or (target.removeprefix("docs/") if target.startswith("docs/") else None)
        return f"]({inside}{found[2] or ''})" if inside else "](" + "#" + ")"

    return _LINK.sub(mended, markdown)


def _parts() -> str:
    """Return the page of what there is to choose from, made from the registries."""
    from gpsec.console.listing import lines

    text = ["# Attacks, detectors, responses, profiles", "", "As `gpsec list` says it; made from the registries."]
    for kind in _KINDS:
        text += ["", f"## {kind.capitalize()}", "", "| name | |", "|---|---|"]
        for line in lines(kind, ROOT / "scenarios"):
            name, _, said = line.partition(" ")
            text.append(f"| `{name}` | {said.strip().replace('|', '&#124;')} |")
    return "\n".join(text) + "\n"


def _api() -> str:
    """Return the page of what can be called, whose text comes from the docstrings."""
    return "# Python, name by name\n\n" + "\n".join(f"::: {module}\n" for module in _MODULES)
