"""`gpsec demand`: random traffic for a net."""

from pathlib import Path

from gpsec.console.complaint import say
from gpsec.console.status import status
from gpsec.console.terminal import messages
from gpsec.demand.make import make_demand, net_name


def demand(
    net_file: Path, out: Path | None, period_s: float | None, duration_s: float, seed: int, overwrite: bool
) -> None:
    """Make the demand and print what came of it.

    Raises:
        GpsecError: the net or the output cannot be used.
    """
    folder = out or Path(net_name(net_file))
    with status(messages(), f"{net_file.name}: ") as tell:
        done = make_demand(
            net_file, folder, period_s=period_s, duration_s=duration_s, seed=seed, overwrite=overwrite, tell=tell
        )
    what = f"{done.vehicles} vehicles on random trips" if done.vehicles else f"{done.flows} flows along single roads"
    say(f"{done.sumocfg}: {what}, one every {done.period_s:.2g} s for {duration_s:g} s")
    say(f"  now: gpsec run {done.sumocfg}")
