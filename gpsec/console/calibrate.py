"""`gpsec calibrate`: thresholds of rare false alarms, with the bars of training."""

from pathlib import Path
from time import perf_counter
from typing import Annotated

import typer

from gpsec.console import options
from gpsec.console.train import display_training


def calibrate(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Trained models, which get the thresholds.")] = Path(
        "models"
    ),
    hours: Annotated[float, typer.Option(min=20.0, metavar="H", help="Benign vehicle-hours for each model.")] = 1000.0,
    jobs: Annotated[int | None, typer.Option(min=1, metavar="N", help="Processes. [default: the cores]")] = None,
    detectors: Annotated[
        list[str] | None, typer.Option("--detector", metavar="X", help="Only this detector; repeatable.")
    ] = None,
    profiles: Annotated[
        list[str] | None, typer.Option("--profile", metavar="P", help="Only this sensor profile; repeatable.")
    ] = None,
    part: options.Part = None,
    tapes: options.PlayedTapes = None,
) -> None:
    """Calibrate rare false alarms (0.1/h, 0.01/h, 1e-3/h) of trained models on many hours of benign driving.

    Recorded traffic is sensed again and again with new noise. 0.1/h is counted; what is rarer comes from a model of
    extreme values and is marked so. Interrupted, it goes on with the models that are left.

    \b
    Examples:
      gpsec calibrate --out models
      gpsec calibrate --out models --profile carla --detector cusum
      gpsec calibrate --profile dsd --tape rendered-good --tape rendered-night --out models
      gpsec calibrate --out models --hours 200 --jobs 2
    """  # noqa: D301
    from rich.console import Console

    from gpsec.training import calibrate as calibrate_models

    loaded = options.load_given_parts(part)
    console = Console()
    began = perf_counter()
    with display_training(console) as report:
        made = calibrate_models(
            out,
            hours=hours,
            detectors=detectors or (),
            profiles=profiles or (),
            parts=loaded,
            tapes=tapes or (),
            jobs=jobs,
            report=report,
        )
    said = f"{len(made)} models in {out} calibrated after {perf_counter() - began:.0f} s"
    console.print(said if made else f"{out}: all models are calibrated on {hours:g} vehicle-hours", highlight=False)
