"""Renders a page: one HTML file that holds its style, scripts and data."""

import base64
import gzip
import json
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from gpsec.core.caches import plotly_file, read
from gpsec.core.caches import write as keep
from gpsec.outcomes.tables import whole
from gpsec.report.formatting import figure

_ASSETS = files("gpsec.report") / "assets"


def render(template: str, data: dict[str, Any], **names: Any) -> str:
    """Render `template` with `names`; `data` is for the page's script.

    Whatever comes from a run is escaped: by the template in HTML, and by the script before Plotly sees it.
    """
    return (
        _environment()
        .get_template(template)
        .render(
            **names,
            style=_asset("report.css"),
            script=_asset("legend.js") + _asset("report.js"),
            plotly=_plotly(),
            data=packed(json.dumps(data, separators=(",", ":"), allow_nan=False)),
        )
    )


def packed(text: str, level: int = 6) -> str:
    """Return a text as gzip in base64, which the page's script unpacks; no tag can begin or end in it."""
    return base64.b64encode(gzip.compress(text.encode(), level, mtime=0)).decode()


def unpacked(text: str) -> str:
    """Return the text that `packed` was given."""
    return gzip.decompress(base64.b64decode(text)).decode()


def write_page(path: Path, text: str) -> None:
    """Write a page; where that fails, the former file stays."""
    with whole(path) as partial:
        partial.write_text(text, encoding="utf-8")


@cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("gpsec.report", "assets"),
        autoescape=select_autoescape(default=True, default_for_string=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["figure"] = figure
    return made


def _asset(name: str) -> Markup:
    return Markup((_ASSETS / name).read_text("utf-8"))


def _plotly() -> str:
    """Return Plotly's script, packed; packing takes a second, so the result is cached."""
    kept = plotly_file()
    found = read(kept)
    if found is not None:
        return found.decode("ascii")
    from plotly.offline import get_plotlyjs

    text = packed(get_plotlyjs(), 9)
    keep(kept, text.encode("ascii"))
    return text
