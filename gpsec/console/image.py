"""`gpsec image`: the lane in pictures."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.console import options
from gpsec.console.errors import say
from gpsec.core.errors import GpsecError

if TYPE_CHECKING:
    from gpsec.imaging.filming.film import Film
    from gpsec.scenario import Scenario

image = typer.Typer(
    name="image",
    help="""Render, detect, calibrate and measure: the camera's lane by pictures; needs the extra 'image'.

    \b
    Examples:
      gpsec image render scenarios/highway --vehicle ID --weather rain --out frames
      gpsec image detect drive.mp4 --calibration calibration.json --overlay video
      gpsec image measure scenarios/highway --weather good,night --out camera
    """,
)
_Scenario = Annotated[str, typer.Argument(metavar="SCENARIO", help="As `gpsec run` takes it.")]
_From = Annotated[float, typer.Option("--from", min=0.0, metavar="S", help="Simulated time of the first picture.")]
_To = Annotated[float, typer.Option("--to", min=0.1, metavar="S", help="Simulated time of the last one.")]
_Mounted = Annotated[
    float,
    typer.Option("--extrinsics-deg", min=0.0, max=5.0, metavar="DEG", help="Unknown error of mounting, σ of an axis."),
]
_Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder to write to.")]


@image.command("render")
def image_render(
    scenario: _Scenario,
    out: _Out,
    vehicle: Annotated[str, typer.Option(metavar="ID", help="Whose view; any vehicle of SUMO.")],
    from_s: _From = 60.0,
    to_s: _To = 70.0,
    weather: Annotated[str, typer.Option(metavar="W", help="good, night, rain, rain-night, worn, shadows.")] = "good",
    extrinsics_deg: _Mounted = 0.1,
    set_: options.Set = None,
) -> None:
    """Render what the front camera of a vehicle shows, with the truth of each picture and the calibration.

    \b
    Examples:
      gpsec image render scenarios/highway --vehicle f3.7 --from 60 --to 90 --weather rain --out frames
      gpsec image detect frames --calibration frames/calibration.json --out lanes
    """  # noqa: D301
    from gpsec.imaging.filming.views import render_view
    from gpsec.imaging.pictures.opencv import opencv
    from gpsec.imaging.pictures.weather import weather_of

    opencv()
    chosen = weather_of(weather)
    with _progress() as bar:
        _, film = _film(scenario, from_s, to_s, set_, bar)
        count = render_view(film, vehicle, chosen, extrinsics_deg, out, bar("pictures"))
    say(f"{out}: {count} pictures, truth.csv, calibration.json")


@image.command("calibrate")
def image_calibrate(
    boards: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Pictures of a chessboard, for focal length and distortion.")
    ] = None,
    straight: Annotated[
        Path | None, typer.Option(metavar="DIR|VIDEO", help="Frames of a straight lane, for pitch, yaw and height.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The calibration file.")] = Path(
        "calibration.json"
    ),
    corners: Annotated[str, typer.Option(metavar="NxM", help="Inner corners of the board.")] = "9x6",
    focal_px: Annotated[
        float | None, typer.Option(min=10.0, max=1e5, metavar="PX", help="Focal length, where there are no boards.")
    ] = None,
    lane_width: Annotated[float, typer.Option(min=2.0, max=6.0, metavar="M", help="Of the straight lane.")] = 3.7,
    ahead: Annotated[float, typer.Option(min=-5.0, max=20.0, metavar="M", help="From rear axle to camera.")] = 1.7,
    hood_row: Annotated[int | None, typer.Option(min=1, metavar="ROW", help="First row that shows the hood.")] = None,
) -> None:
    """Calibrate a camera by pictures of a chessboard, and by frames of a straight lane.

    \b
    Examples:
      gpsec image calibrate --boards boards --straight straight --lane-width 3.7 --out calibration.json
      gpsec image calibrate --straight drive.mp4 --focal-px 870 --out calibration.json
    """  # noqa: D301
    from dataclasses import replace

    from gpsec.imaging.pictures.calibrate import lens_of, mounted
    from gpsec.imaging.pictures.calibration import write_calibration
    from gpsec.imaging.pictures.camera import RoadCamera
    from gpsec.imaging.pictures.frames import open_frames

    board = _corners(corners)
    if boards is not None:
        lens = lens_of(list(open_frames(boards).shots()), board)
        camera = lens.camera
        say(f"{lens.boards} boards, corners within {lens.error_px:.2f} px; f {camera.fx:.1f} px")
        if lens.left_out:
            say(f"  left out, without a whole board or of another size: {', '.join(lens.left_out)}")
    elif straight is not None and focal_px is not None:
        first = next(open_frames(straight).shots()).picture
        height, width = first.shape[:2]
        middle = (0.5 * (width - 1), 0.5 * (height - 1))
        camera = RoadCamera(width, height, focal_px, focal_px, *middle, hood_row=height)
    else:
        raise GpsecError("expected --boards, or --straight with --focal-px, found neither")
    camera = replace(camera, x_m=ahead, hood_row=min(hood_row or camera.height, camera.height))
    if straight is not None:
        shots = [
            shot for number, shot in enumerate(open_frames(straight).shots(camera)) if number % 25 == 0 or number < 5
        ]
        camera = mounted(camera, shots, lane_width)
        say(f"pitch {camera.pitch_deg:.2f}°, yaw {camera.yaw_deg:.2f}°, height {camera.z_m:.2f} m")
    write_calibration(camera, out)
    say(out)


@image.command("detect")
def image_detect(
    frames: Annotated[Path, typer.Argument(metavar="FRAMES|VIDEO", help="A folder of pictures, or a video.")],
    calibration: Annotated[Path, typer.Option(metavar="FILE", help="Of the camera that took them.")],
    out: _Out = Path("lanes"),
    lane_width: Annotated[
        float | None, typer.Option(min=2.0, max=6.0, metavar="M", help="As the map has it. [default: 2.6 to 4.2]")
    ] = None,
    memory: Annotated[
        float | None, typer.Option(min=0.1, max=200.0, metavar="M", help="Average over this way, by the odometer.")
    ] = None,
    overlay: Annotated[str, typer.Option(metavar="KIND", help="none, pictures, video or animation.")] = "none",
    rate_hz: Annotated[float | None, typer.Option(min=0.01, max=1e3, metavar="HZ", help="Pictures a second.")] = None,
) -> None:
    """Find the lane in pictures: lanes.csv with C0 … C3 at the rear axle, width, stated σ, and whether it is valid.

    \b
    Examples:
      gpsec image detect frames --calibration calibration.json --out lanes
      gpsec image detect drive.mp4 --calibration calibration.json --overlay video
      gpsec image detect frames --calibration frames/calibration.json --overlay animation --out film
    """  # noqa: D301
    from gpsec.imaging.pictures.calibration import read_calibration
    from gpsec.imaging.pictures.detect import LANES, detect_lanes
    from gpsec.imaging.pictures.folder import filled_folder
    from gpsec.imaging.pictures.frames import open_frames
    from gpsec.imaging.pictures.overlay import OVERLAYS

    if overlay not in OVERLAYS:
        raise GpsecError(f"--overlay: expected {', '.join(OVERLAYS)}, found '{overlay}'")
    camera = read_calibration(calibration)
    found = open_frames(frames, rate_hz)
    with _progress() as bar, filled_folder(out) as part:
        seen = detect_lanes(
            found, camera, part, width_m=lane_width, memory_m=memory, overlay=overlay, tell=bar("pictures")
        )
    jitter = "" if seen.jitter_m is None else f", C0 from one to the next {seen.jitter_m:.3f} m (σ/√2)"
    say(f"{out / LANES}: a lane in {seen.lanes} of {seen.pictures} pictures{jitter}")


@image.command("figure")
def image_figure(
    panels: Annotated[
        list[str], typer.Argument(metavar="[TITLE=]PICTURE…", help="Each with the calibration.json beside it.")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The figure, such as lanes.jpg.")],
    columns: Annotated[int, typer.Option(min=1, max=20, metavar="N", help="Pictures in a row.")] = 2,
    width: Annotated[int, typer.Option(min=80, max=4000, metavar="PX", help="Of each picture.")] = 480,
    lane_width: Annotated[
        float | None, typer.Option(min=2.0, max=6.0, metavar="M", help="As the map has it. [default: 2.6 to 4.2]")
    ] = None,
) -> None:
    """Put pictures side by side, rendered or your own, each with the lane that is found in it.

    \b
    Examples:
      gpsec image figure good=good/00100.png rain=rain/00100.png --out lanes.jpg
      gpsec image calibrate --straight drive --focal-px 870 --out drive/calibration.json
      gpsec image figure rendered=good/00100.png real=drive/0001.jpg --out rendered-real.jpg
    """  # noqa: D301
    from gpsec.imaging.pictures.figure import Panel, write_figure

    write_figure([Panel.of(text) for text in panels], out, columns=columns, width=width, lane_width_m=lane_width)
    say(out)


@image.command("measure")
def image_measure(
    scenarios: options.Scenarios,
    out: _Out,
    weather: Annotated[str, typer.Option(metavar="W,…", help="One after the other.")] = "good,night,rain,worn",
    vehicles: Annotated[int, typer.Option(min=1, max=10000, metavar="N", help="How many of each scenario.")] = 20,
    from_s: _From = 60.0,
    to_s: _To = 120.0,
    extrinsics_deg: _Mounted = 0.1,
    set_: options.Set = None,
) -> None:
    """Measure the errors of the image channel: errors.csv, tapes of each weather (rendered-….npz), and a figure.

    Vehicles are drawn by their names. What is done is kept in DIR/parts: where it was stopped, the same command goes
    on.

    \b
    Examples:
      gpsec image measure scenarios/highway --weather good,rain --vehicles 20 --out camera
      gpsec image measure scenarios/town --weather noiseless --extrinsics-deg 0 --out exact
    """  # noqa: D301
    from gpsec.core.system import in_a_sentence
    from gpsec.core.version import __version__
    from gpsec.imaging.filming.findings import write_findings
    from gpsec.imaging.filming.measure import Campaign, Errors
    from gpsec.imaging.pictures.opencv import opencv
    from gpsec.imaging.pictures.weather import weather_of

    opencv()
    names = list(dict.fromkeys(name.strip() for name in weather.split(",")))
    for name in names:
        weather_of(name)
    measured: dict[str, dict[str, list[Errors]]] = {}
    steps_s = {}
    with _progress() as bar:
        for argument in scenarios:
            scenario, film = _film(argument, from_s, to_s, set_, bar)
            with in_a_sentence(f"{out}: no folder can be made there"):
                out.mkdir(parents=True, exist_ok=True)
            campaign = Campaign(film, scenario.model_dump_json(), extrinsics_deg, out)
            chosen, short = campaign.vehicles(vehicles), scenario.name
            measured[short] = {name: campaign.measure(name, chosen, bar(f"{short}, {name}")) for name in names}
            steps_s[short] = film.step_s
    if len(set(steps_s.values())) > 1:
        raise GpsecError(
            f"expected scenarios of one step, found {', '.join(f'{k} {v:g} s' for k, v in steps_s.items())}"
        )
    made = {
        "made_by": f"gpsec {__version__} image measure",
        "from_s": from_s,
        "to_s": to_s,
        "vehicles": vehicles,
        "extrinsics_deg": extrinsics_deg,
    }
    for row in write_findings(measured, next(iter(steps_s.values())), made, out):
        say(
            f"{row.scenario}, {row.weather}, {row.mode}, {row.place}: lost {row.lost_share:.1%}, "
            f"C0 {row.c0_mean_m:+.3f} ± {row.c0_mad_m:.3f} m (MAD), p99 {row.c0_p99_m:.2f} m, "
            f"C1 {row.c1_mad_deg:.2f}°, τ {row.tau_s:.1f} s, σ × {row.sigma_ratio:.2f}"
        )
    say(out / "errors.csv")


def _film(argument: str, from_s: float, to_s: float, sets: list[str] | None, bar: "_Bar") -> tuple["Scenario", "Film"]:
    """Run the traffic of a scenario and keep it from one time to another."""
    from gpsec.imaging.filming.film import film
    from gpsec.scenario import load_scenario

    if to_s <= from_s:
        raise GpsecError(f"--to: expected more than --from ({from_s:g}), found {to_s:g}")
    scenario = load_scenario(argument, options.changes(sets, None))
    return scenario, film(scenario, from_s, to_s, bar(f"{scenario.name}, traffic (s)"))


_Bar = Callable[[str], Callable[[int, int], None]]


@contextmanager
def _progress() -> Iterator[_Bar]:
    """Give what begins a bar (a line now and then, where there is no terminal) and returns what moves it on."""
    from gpsec.console.bars import Counted
    from gpsec.console.terminal import messages

    with Counted(messages()) as bars:
        yield bars.begin


def _corners(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdigit() and 2 <= int(part) <= 50 for part in parts):
        raise GpsecError(f"--corners: expected two numbers of inner corners such as 9x6, found '{text}'")
    return int(parts[0]), int(parts[1])
