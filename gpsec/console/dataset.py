"""`gpsec dataset`: labelled residuals, fixes, camera and truth as files for other tools."""

from pathlib import Path
from typing import Annotated

import typer

from gpsec.console.errors import say


def dataset(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="A new or empty folder.")],
    profile: Annotated[str, typer.Option(metavar="P", help="Sensor profile of the fleet.")] = "carla",
    duration: Annotated[
        float | None,
        typer.Option(min=20.0, metavar="S", help="Simulated seconds of each run. [default: all of a training network]"),
    ] = None,
    networks: Annotated[
        str | None, typer.Option(metavar="A,B", help="Only these networks. [default: all of training and suite]")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Processes at a time. [default: the cores]")
    ] = None,
) -> None:
    """Write residuals, fixes, camera, truth and attack labels of every track-step to Parquet, with a data card.

    Split into train, calibration and test by network and seed, so that PyOD, scikit-learn or any torch model can be
    trained without gpsec. The same versions write the same bytes. Interrupted, the same call goes on.

    \b
    Examples:
      gpsec dataset spoofing
      gpsec dataset spoofing-dsd --profile dsd
      gpsec dataset small --networks suburb,sharp_turns --duration 60
    """  # noqa: D301
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages
    from gpsec.core.errors import GpsecError, nearest, shown
    from gpsec.core.threads import cores
    from gpsec.paper.dataset import Export, check_empty, make_dataset
    from gpsec.paper.entering import check_profile_known
    from gpsec.paper.suite import STANDARD
    from gpsec.running.folders import resolved
    from gpsec.running.workshop import workshop
    from gpsec.scenario.networks import TRAINING_NETWORKS

    check_profile_known(profile)
    known = (*TRAINING_NETWORKS, *STANDARD.networks)
    chosen = tuple(name.strip() for name in networks.split(",")) if networks else ()
    for name in chosen:
        if name not in known:
            raise GpsecError(f"--networks: no network '{shown(name)}': {nearest(name, known)}")
    target = resolved(out)
    check_empty(target)
    export = Export(profile, duration, chosen)
    count = sum(map(len, export.runs().values()))
    with workshop(target) as work, display(messages(), count) as show:
        work.begin(resume=True)
        made = make_dataset(export, target, work, jobs or cores(), show)
    say(f"{made}: {count} files")
