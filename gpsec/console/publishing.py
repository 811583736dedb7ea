"""`gpsec table` and `gpsec figure`: what goes from runs into a paper."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gpsec.console.errors import say
from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence

if TYPE_CHECKING:
    from gpsec.report.gathering import Gathered

_Runs = Annotated[list[Path], typer.Argument(metavar="RUN...", help="Folders of runs; seeds of a scenario are pooled.")]


def table(
    runs: _Runs,
    name: Annotated[
        str,
        typer.Option("--name", metavar="NAME", help="table1, detection, matched, localization, outcomes or defences."),
    ] = "defences",
    latex: Annotated[bool, typer.Option("--latex", help="For LaTeX, with the package booktabs.")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="As Markdown, which is what it is without.")] = False,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Write it there. [default: print it]")
    ] = None,
) -> None:
    """Print a table of one run or more for a paper, with vehicles, seeds and intervals in its caption.

    table1 has the form of the paper's Table I, its figures and ours side by side.

    \b
    Examples:
      gpsec table results/town --markdown
      gpsec table results/seed1 results/seed2 --name outcomes --latex
      gpsec table results/fleet-eval --name table1 --latex --out table1.tex
    """  # noqa: D301
    from gpsec.outcomes.tables import whole
    from gpsec.report.published_tables import make_tables
    from gpsec.report.typesetting import as_latex, as_markdown

    if latex and markdown:
        raise GpsecError("--latex, --markdown: expected one of them, found both")
    made = make_tables(name, _gathered(runs))
    text = "\n".join((as_latex if latex else as_markdown)(one) for one in made)
    if out is None:
        for line in text.splitlines():
            say(line)
        return
    with in_a_sentence(f"{out}: cannot be written"), whole(out) as partial:
        partial.write_text(text, encoding="utf-8")
    say(out)


def figure_(
    arguments: Annotated[
        list[str],
        typer.Argument(metavar="RUN... NAME", help="Folders of runs, and outcomes, decision, roc, delay or error."),
    ],
    pdf: Annotated[
        bool, typer.Option("--pdf", help="As PDF with embedded fonts, which is what it is without.")
    ] = False,
    svg: Annotated[bool, typer.Option("--svg", help="As SVG, its letters as outlines.")] = False,
    scenario: Annotated[str | None, typer.Option(metavar="NAME", help="[default: the first]")] = None,
    profile: Annotated[str | None, typer.Option(metavar="P", help="[default: the first]")] = None,
    attack: Annotated[str | None, typer.Option(metavar="PLAN", help="[default: the first]")] = None,
    width: Annotated[Literal["column", "text"], typer.Option("--width", help="Of a page with two columns.")] = "column",
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="[default: NAME.pdf or NAME.svg, here]")
    ] = None,
) -> None:
    """Draw a figure of one run or more for a paper, and print its caption.

    \b
    Examples:
      gpsec figure results/town outcomes --pdf
      gpsec figure results/seed1 results/seed2 decision --svg --width text
      gpsec figure results/fleet-eval roc --scenario highway --attack stealth --out roc.pdf
    """  # noqa: D301
    from gpsec.report.published_figures import Picture, draw_figure, first_of

    if pdf and svg:
        raise GpsecError("--pdf, --svg: expected one of them, found both")
    if len(arguments) < 2:
        raise GpsecError(f"RUN... NAME: expected the folder of a run and the name of a figure, found '{arguments[0]}'")
    *folders, name = arguments
    found = _gathered([Path(folder) for folder in folders])
    path = out or Path(f"{name}.{'svg' if svg else 'pdf'}")
    if path.suffix not in (".pdf", ".svg"):
        raise GpsecError(f"--out {path}: expected the ending .pdf or .svg")
    with in_a_sentence(f"{path}: cannot be written"):
        caption = draw_figure(name, found, Picture(*first_of(found, (scenario, profile, attack)), width, path))
    say(path)
    say(caption)


def _gathered(folders: Sequence[Path]) -> "Gathered":
    from gpsec.report.gathering import taken_together
    from gpsec.running.results import load

    return taken_together([load(folder) for folder in folders])
