"""Joins the commands, one of which each module here has, and answers a command line."""

from collections.abc import Callable
from typing import Annotated

import typer

from gpsec.console.bench_detector import bench_detector
from gpsec.console.calibrate import calibrate
from gpsec.console.check import check
from gpsec.console.clean import clean
from gpsec.console.dataset import dataset
from gpsec.console.demand import demand
from gpsec.console.image import image
from gpsec.console.importing import import_
from gpsec.console.judge import judge
from gpsec.console.listing import list_
from gpsec.console.new import new
from gpsec.console.paper import paper
from gpsec.console.publishing import figure_, table
from gpsec.console.replay import replay
from gpsec.console.report import report
from gpsec.console.run import run
from gpsec.console.schema import schema
from gpsec.console.search import search
from gpsec.console.show import show
from gpsec.console.stress import stress
from gpsec.console.sweep import sweep
from gpsec.console.trace import trace
from gpsec.console.train import train
from gpsec.console.verify import verify
from gpsec.core.errors import GpsecError

app = typer.Typer(
    name="gpsec",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def answer(arguments: list[str]) -> int:
    """Do what the command line asks for and return the exit status.

    Raises:
        GpsecError: the user cannot have meant that.
        KeyboardInterrupt: the user has had enough.
    """
    try:
        return app(arguments, prog_name="gpsec", standalone_mode=False) or 0
    except typer.TyperException as error:
        raise GpsecError(_usage(error)) from None
    except typer.Abort:
        raise KeyboardInterrupt from None


def _usage(error: typer.TyperException) -> str:
    """Return what is wrong with the command line, as one sentence in our form."""
    meant = getattr(error, "possibilities", None)
    said = error.message if meant else error.format_message()
    said = said.strip().rstrip(".").replace(". Did you", "; did you").replace("Input should be", "expected")
    hint = f"; did you mean {' or '.join(sorted(meant))}?" if meant else ""
    return f"{said[:1].lower()}{said[1:]}{hint}"


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import PackageNotFoundError, version

        try:
            print(f"gpsec {version('gpsec')}")
        except PackageNotFoundError:
            print("gpsec, not installed")
        raise typer.Exit


@app.callback()
def gpsec(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Evaluate GPS-spoofing attacks on automated vehicles in SUMO traffic.

    \b
    Examples:
      gpsec run scenarios/town
      gpsec run scenarios/town scenarios/highway --out results/both
      gpsec check scenarios/town
      gpsec import town.xodr
      gpsec sweep plan.toml
      gpsec list attacks
    """  # noqa: D301


_COMMANDS: dict[str, Callable[..., int | None]] = {
    "run": run,
    "replay": replay,
    "show": show,
    "report": report,
    "table": table,
    "figure": figure_,
    "verify": verify,
    "trace": trace,
    "check": check,
    "import": import_,
    "demand": demand,
    "list": list_,
    "new": new,
    "clean": clean,
    "schema": schema,
    "train": train,
    "calibrate": calibrate,
    "paper": paper,
    "stress": stress,
    "sweep": sweep,
    "search": search,
    "bench-detector": bench_detector,
    "dataset": dataset,
    "judge": judge,
}
for _name, _command in _COMMANDS.items():
    app.command(_name)(_command)
app.add_typer(image)
