"""`gpsec demand`: random traffic for a net."""

from pathlib import Path
from typing import Annotated

import typer

from gpsec.console.errors import say


def demand(
    net_file: Annotated[Path, typer.Argument(metavar="NET", help="A net of SUMO (.net.xml).")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="The folder to write to. [default: NET's name, here]")
    ] = None,
    period: Annotated[
        float | None,
        typer.Option(min=0.01, max=3600.0, metavar="S", help="Time between departures. [default: by the net's size]"),
    ] = None,
    duration: Annotated[
        float, typer.Option(min=1.0, max=1e6, metavar="S", help="For how long vehicles depart.")
    ] = 360.0,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, metavar="N", help="Of all that is random.")] = 1,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")] = False,
) -> None:
    """Make random traffic for a net, as a folder that `gpsec run` takes.

    \b
    Examples:
      gpsec demand town.net.xml
      gpsec demand town.net.xml --out busy --period 0.5 --duration 600 --seed 7
      gpsec run town/town.sumocfg
    """  # noqa: D301
    from gpsec.console.terminal import messages, status
    from gpsec.demand.make import make_demand, net_name

    folder = out or Path(net_name(net_file))
    with status(messages(), f"{net_file.name}: ") as tell:
        done = make_demand(
            net_file, folder, period_s=period, duration_s=duration, seed=seed, overwrite=overwrite, tell=tell
        )
    what = f"{done.vehicles} vehicles on random trips" if done.vehicles else f"{done.flows} flows along single roads"
    say(f"{done.sumocfg}: {what}, one every {done.period_s:.2g} s for {duration:g} s")
    say(f"  now: gpsec run {done.sumocfg}")
