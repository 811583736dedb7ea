"""`gpsec import`: a net from a map, and a verdict on it."""

from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.console.errors import say
from gpsec.core.errors import GpsecError, MachineError

if TYPE_CHECKING:
    from gpsec.opendrive.check import Check, MapDeviation
    from gpsec.opendrive.importing import Imported
    from gpsec.openstreetmap.importing import ImportedExtract

# Above this share of points a map alone keeps a detector busy: the false-alarm rate it was calibrated to.
_BUSY_SHARE = 1e-3
_NOT_CHECKED = (
    "lanes lie where netconvert lays them beside OpenStreetMap's lines, which are the middles of roads: "
    "there is nothing to check them against"
)


def import_(
    map_file: Annotated[
        Path,
        typer.Argument(metavar="MAP", help="An OpenDRIVE map (.xodr) or an OpenStreetMap extract (.osm, .osm.gz)."),
    ],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="NET", help="The net to write. [default: MAP.net.xml, here]")
    ] = None,
    origin: Annotated[
        str | None,
        typer.Option(metavar="LAT,LON", help="Where an OpenDRIVE map's origin lies. [default: what the map says]"),
    ] = None,
    left_hand: Annotated[
        bool | None,
        typer.Option(
            "--left-hand/--right-hand",
            help="The side that traffic keeps to on an OpenStreetMap extract. [default: found out]",
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")] = False,
    allow_loss: Annotated[
        bool, typer.Option("--allow-loss", help="Exit status 0 also where the net is without more than 3 % of the map.")
    ] = False,
) -> None:
    """Make a SUMO net of an OpenDRIVE map, and check its lanes against the map's; or of an OpenStreetMap extract.

    Of an OpenDRIVE map it writes the net, a CSV with the errors of each lane (NET.check.csv) and a picture of them
    (NET.check.png); of OpenStreetMap, which has no lanes to check against, the net.

    \b
    Examples:
      gpsec import town.xodr
      gpsec import town.xodr --out nets/town.net.xml --origin 52.26,10.53
      gpsec import city.osm.gz
    """  # noqa: D301
    from gpsec.opendrive.netfile import NET_SUFFIX
    from gpsec.openstreetmap.extract import is_extract

    if not map_file.is_file():
        raise GpsecError(f"{map_file}: expected an OpenDRIVE map or an OpenStreetMap extract, found no such file")
    target = out or Path(f"{_stem(map_file)}{NET_SUFFIX}")
    if is_extract(map_file):
        if origin is not None:
            raise GpsecError(f"--origin {origin}: expected an OpenDRIVE map; OpenStreetMap says itself where it lies")
        _import_osm(map_file, target, left_hand, overwrite)
        return
    if left_hand is not None:
        raise GpsecError(
            "--left-hand: expected an OpenStreetMap extract; an OpenDRIVE map says itself which side it is"
        )
    place = None if origin is None else parse_origin(origin)
    _import_opendrive(map_file, target, place, overwrite, allow_loss)


def _import_opendrive(
    map_file: Path, net: Path, origin_deg: tuple[float, float] | None, overwrite: bool, allow_loss: bool
) -> None:
    """Import an OpenDRIVE map and print what came of it.

    Raises:
        GpsecError: the map or the output cannot be used.
        MachineError: the net, which is written then, has too little of the map and `allow_loss` does not accept that.
    """
    from gpsec.console.terminal import messages, status
    from gpsec.opendrive.check import MOST_LOST_SHARE
    from gpsec.opendrive.importing import import_map

    with status(messages(), f"{map_file.name}: ") as tell:
        done = import_map(
            map_file, net, origin_deg=origin_deg, alarm_m=alarm_levels_m(), overwrite=overwrite, tell=tell
        )
    for line in verdict(done):
        say(line)
    if done.check.incomplete and not allow_loss:
        raise MachineError(
            f"{map_file}: {done.check.overall.unmatched_share:.1%} of its lanes' length, more than "
            f"{MOST_LOST_SHARE:.0%}, has no lane in {done.net}, which was written; --allow-loss accepts that"
        )


def _import_osm(map_file: Path, net: Path, left_hand: bool | None, overwrite: bool) -> None:
    """Import an extract of OpenStreetMap and print what came of it.

    Raises:
        GpsecError: the extract or the output cannot be used.
    """
    from gpsec.console.terminal import messages, status
    from gpsec.openstreetmap.importing import import_extract

    with status(messages(), f"{map_file.name}: ") as tell:
        done = import_extract(map_file, net, left_hand=left_hand, overwrite=overwrite, tell=tell)
    for line in _net_verdict(done):
        say(line)


def _stem(map_file: Path) -> str:
    name = map_file.name
    for suffix in (".gz", ".bz2", ".xml", ".xodr", ".osm"):
        name = name.removesuffix(suffix)
    return name


def parse_origin(text: str) -> tuple[float, float]:
    """Return latitude and longitude in degrees of "LAT,LON".

    Raises:
        GpsecError: it is no such place.
    """
    try:
        lat, lon = (float(part) for part in text.split(","))
    except ValueError:
        lat = lon = float("nan")
    if not (abs(lat) <= 90.0 and abs(lon) <= 180.0):
        raise GpsecError(f"--origin {text}: expected latitude and longitude in degrees, such as 52.26,10.53")
    return lat, lon


def alarm_levels_m() -> dict[str, float]:
    """Return for each sensor profile the steady residual (m) at which its chi-square detector raises an alarm.

    The statistic is the mean of (z/σ)², so a residual that does not change raises one from σ·√threshold on.
    """
    from gpsec.detection.models import thresholds_for
    from gpsec.sensors.profiles import residual_sigma_m
    from gpsec.sensors.registry import PROFILES
    from gpsec.types.points import PER_SAMPLE

    names = list(PROFILES)
    thresholds = thresholds_for([("chi_square", PER_SAMPLE)], names, "tracked")[:, 0]
    return {
        name: residual_sigma_m(PROFILES[name]) * sqrt(threshold)
        for name, threshold in zip(names, thresholds, strict=True)
    }


def verdict(done: "Imported") -> list[str]:
    """Return what to say of an import."""
    from gpsec.opendrive.lanes import NARROWEST_M

    check = done.check
    lines = [
        f"{done.net}: {done.lanes} lanes",
        f"  net against map, across the lane: {_figures(check.overall)}",
        f"  as netconvert made it:            {_figures(done.raw)}",
        *_alarms(check),
    ]
    if check.narrow_share > 0.0:
        lines.append(f"  left out of the check: {check.narrow_share:.1%} that is narrower than {NARROWEST_M:g} m")
    lines += [f"  mended: {sentence}" for sentence in done.mended]
    lines += [f"  note: {sentence}" for sentence in done.notes]
    return [*lines, f"  by lane: {done.csv}; drawn: {done.picture}"]


def _figures(figures: "MapDeviation") -> str:
    if figures.median_m is None:
        return "no lane of the net lies where the map has one"
    return (
        f"median {_length(figures.median_m)}, 95 % under {_length(figures.p95_m)}, "
        f"largest {_length(figures.largest_m)}, {figures.unmatched_share:.1%} unmatched"
    )


def _length(metres: float | None) -> str:
    value = metres or 0.0
    return f"{value:.2f} m" if value >= 0.1 else f"{1000.0 * value:.1f} mm"


def _alarms(check: "Check") -> list[str]:
    levels = ", ".join(f"{level:.2f} m ({name})" for name, level in check.alarm_m.items())
    busy = [f"{share:.1%} ({name})" for name, share in check.over_share.items() if share > _BUSY_SHARE]
    said = f"there on {', '.join(busy)} of the way" if busy else "practically nowhere on the way"
    return [f"  a chi-square detector alarms at a steady {levels}: map errors as large are {said}"]


def _net_verdict(done: "ImportedExtract") -> list[str]:
    return [
        f"{done.net_file}: {done.lanes} lanes, {done.length_m / 1000.0:.1f} km of them",
        *(f"  mended: {sentence}" for sentence in done.mended),
        *(f"  note: {sentence}" for sentence in (*done.notes, _NOT_CHECKED)),
        f"  now: gpsec demand {done.net_file}",
    ]
