"""The commands and their options. What takes long to import is imported by the command that needs it."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from gpsec.console.complaint import complain, say
from gpsec.console.listing import KINDS, lines
from gpsec.core import shipped
from gpsec.core.errors import GpsecError

app = typer.Typer(
    name="gpsec",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

_Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a key of gpsec.toml, such as fleet.profile=consumer."),
]
_Scenarios = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENARIO", help="A scenario folder, its gpsec.toml, any .sumocfg, or a name of `gpsec list scenarios`."
    ),
]
_Profile = Annotated[
    str | None, typer.Option("--profile", metavar="P", help="Sensor profile of the whole fleet (fleet.profile).")
]
_Part = Annotated[
    list[str] | None,
    typer.Option(
        "--part", metavar="REF", help="Load a part: FILE.py:Name, package.module:Name, or a profile FILE.toml."
    ),
]
_RunsCode = Annotated[bool, typer.Option("--allow-code", help="Run the code that RUN's scenario names as `parts`.")]
_AllowCode = Annotated[bool, typer.Option("--allow-code", help="Run the code that a scenario names under `parts`.")]


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


def _load_parts(references: list[str] | None) -> tuple[str, ...]:
    """Load the parts that the command line names; return their references with whole paths."""
    if not references:
        return ()
    from gpsec.scenario.outside import load_parts

    try:
        return load_parts(references, Path(), allow_code=True)
    except ValueError as error:
        raise GpsecError(f"--part: {error}") from None


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
      gpsec list attacks
    """  # noqa: D301


@app.command()
def run(
    scenarios: _Scenarios,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="One folder for all scenarios. [default: results/<scenario>]"),
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Of SUMO and of all noise (seed).")] = None,
    duration: Annotated[
        float | None, typer.Option(metavar="S", help="Simulated seconds (duration_s). [default: the .sumocfg's]")
    ] = None,
    profile: _Profile = None,
    set_: _Set = None,
    part: _Part = None,
    allow_code: _AllowCode = False,
    log_steps: Annotated[bool, typer.Option("--log-steps", help="Also write every step to steps.parquet.")] = False,
    log_vehicles: Annotated[
        list[str] | None,
        typer.Option("--log-vehicle", metavar="ID", help="Write steps.parquet for this vehicle only; can be repeated."),
    ] = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    format_: Annotated[
        Literal["csv", "parquet"],
        typer.Option("--format", help="With parquet, the large tables are written as Parquet files too."),
    ] = "csv",
    engine: Annotated[
        str | None, typer.Option(metavar="E", help="batched, or reference for small fleets. [default: batched]")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the run that DIR holds.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a run that was interrupted: only what is missing is run.")
    ] = False,
    jobs: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Scenarios at a time. [default: the cores there are]")
    ] = None,
    threads: Annotated[int | None, typer.Option(metavar="N", help="Threads of each scenario (threads).")] = None,
    gui: Annotated[bool, typer.Option("--gui", help="Show the run in sumo-gui; one scenario.")] = False,
    gui_plan: Annotated[
        str | None, typer.Option("--gui-plan", metavar="PLAN", help="The attack that is shown. [default: the first]")
    ] = None,
    gui_defence: Annotated[
        str | None,
        typer.Option("--gui-defence", metavar="D", help="Whose alarms and estimates. [default: the last one]"),
    ] = None,
    gui_delay: Annotated[
        float | None, typer.Option("--gui-delay", min=0.0, max=1e4, metavar="MS", help="For a step. [default: 50]")
    ] = None,
) -> int:
    """Run scenarios, write tables and show them.

    \b
    Examples:
      gpsec run scenarios/town
      gpsec run scenarios/town --duration 120 --seed 7 --profile consumer
      gpsec run scenarios/town --set plans.drift.rate_mps=0.2 --set fleet.equipped_share=0.3
      gpsec run scenarios/* --out results/all --overwrite
      gpsec run scenarios/* --out results/all --resume
      gpsec run scenarios/town --gui --gui-plan spoofed_quarter --gui-defence lstm+ukf
      gpsec run somewhere/else.sumocfg --set 'plans=[{attack="drift", share=0.2}]'
      gpsec run scenarios/town --part mine.py:Zigzag --set 'plans=[{attack="zigzag"}]'
    """  # noqa: D301
    from gpsec.console.launch import Output, launch
    from gpsec.console.live import live_run
    from gpsec.scenario.outside import Outside
    from gpsec.scenario.overrides import Override, parse_set

    shown = live_run(scenarios, gui, gui_plan, gui_defence, gui_delay)
    changes = [parse_set(text) for text in set_ or []]
    flags = {
        ("seed",): (seed, f"--seed {seed}"),
        ("duration_s",): (duration, f"--duration {duration}"),
        ("fleet", "profile"): (profile, f"--profile {profile}"),
        ("engine",): (engine, f"--engine {engine}"),
        ("threads",): (threads, f"--threads {threads}"),
        ("log_steps",): (log_steps or None, "--log-steps"),
        ("log_vehicles",): (log_vehicles or None, "--log-vehicle"),
    }
    changes += [Override(key, value, flag) for key, (value, flag) in flags.items() if value is not None]
    output = Output(out, overwrite, resume, report, format_ == "parquet")
    return launch(scenarios, changes, output, jobs, shown, outside=Outside(tuple(part or ()), allow_code))


@app.command("report")
def report_(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    other: Annotated[
        Path | None, typer.Argument(metavar="[OTHER]", help="Another run: compare both, vehicle by vehicle.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="The page. [default: RUN/report.html, OTHER/comparison.html]"),
    ] = None,
    again: Annotated[
        bool,
        typer.Option("--again", help="Simulate the vehicles that it shows again, if not logged: runs RUN's scenario."),
    ] = False,
    geojson: Annotated[
        bool,
        typer.Option("--geojson", help="Also write RUN/places.geojson, for QGIS: the map and what happened where."),
    ] = False,
    spreadsheet: Annotated[
        bool,
        typer.Option(
            "--spreadsheet",
            help="Also write RUN/*.spreadsheet.csv: the tables, with ' before what Excel would take for a formula.",
        ),
    ] = False,
    part: _Part = None,
    allow_code: _RunsCode = False,
) -> int:
    """Write the report of a run, or the comparison of two: one HTML file that opens offline.

    \b
    Examples:
      gpsec report results/town
      gpsec report results/town --again --geojson
      gpsec report results/before results/after
    """  # noqa: D301
    from gpsec.console.reporting import compare, report

    _load_parts(part)
    if other is None:
        return report(run, out, again=again, geojson=geojson, spreadsheet=spreadsheet, allow_code=allow_code)
    compare(run, other, out)
    return 0


@app.command("verify")
def verify_(runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Folders of runs.")]) -> int:
    """Say of every table of a run whether it is still what was written; the exit status is 1 where one is not.

    Tables are the CSV files, logs of steps and maps; pages and Parquet copies are made of them, and not among them.

    \b
    Examples:
      gpsec verify results/town
      gpsec verify results/town results/highway
    """  # noqa: D301
    from gpsec.console.verify import verify

    return verify(runs)


@app.command()
def trace(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    vehicle: Annotated[str, typer.Argument(metavar="VEHICLE", help="As in vehicles.csv.")],
    scenario: Annotated[str | None, typer.Option(metavar="NAME", help="Where a run has several.")] = None,
    attack: Annotated[
        str | None, typer.Option(metavar="PLAN", help="Which of its attacks, or none. [default: the first]")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The page. [default: RUN/trace-VEHICLE.html]")
    ] = None,
    part: _Part = None,
    allow_code: _RunsCode = False,
) -> None:
    """Tell the story of one vehicle, on the terminal and as a page; it is simulated again if its steps were not logged.

    \b
    Examples:
      gpsec trace results/town car12
      gpsec trace results/fleet-eval car12 --scenario town --attack stealth
    """  # noqa: D301
    from gpsec.console.reporting import tell

    _load_parts(part)
    tell(run, vehicle, scenario, attack, out, allow_code=allow_code)


@app.command()
def check(
    scenarios: _Scenarios,
    profile: _Profile = None,
    set_: _Set = None,
    part: _Part = None,
    allow_code: _AllowCode = False,
) -> int:
    """Validate scenarios without running them: configuration, files, net, and what SUMO says of them.

    \b
    Examples:
      gpsec check scenarios/town
      gpsec check scenarios/* --set fleet.profile=consumer
    """  # noqa: D301
    from gpsec.console.check import check_lines
    from gpsec.scenario.outside import Outside
    from gpsec.scenario.overrides import Override, parse_set

    changes = [parse_set(text) for text in set_ or []]
    if profile is not None:
        changes.append(Override(("fleet", "profile"), profile, f"--profile {profile}"))
    found = set()
    for argument in scenarios:
        try:
            for line in check_lines(argument, changes, Outside(tuple(part or ()), allow_code)):
                say(line)
        except GpsecError as error:
            found.add(complain(error))
    return min(found, default=0)  # a fault of the machine comes before those of the user


@app.command("import")
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
    from gpsec.console.importing import import_ as import_map

    import_map(map_file, out, origin, left_hand, overwrite, allow_loss)


@app.command()
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
    from gpsec.console.demand import demand as make

    make(net_file, out, period, duration, seed, overwrite)


@app.command("list")
def list_(
    kind: Annotated[str, typer.Argument(metavar="KIND", help=f"One of {', '.join(KINDS)}.")],
    folder: Annotated[
        Path | None,
        typer.Option("--dir", metavar="DIR", help="Where scenarios are. [default: ./scenarios, and those of gpsec]"),
    ] = None,
    part: _Part = None,
) -> None:
    """List what there is to choose from.

    \b
    Examples:
      gpsec list attacks
      gpsec list scenarios --dir scenarios
    """  # noqa: D301
    _load_parts(part)
    for line in lines(kind, folder):
        say(line)


@app.command()
def new(
    name: Annotated[Path, typer.Argument(metavar="NAME", help="The folder to make; its last part names the scenario.")],
    net: Annotated[Path, typer.Option("--net", metavar="NET", help="Any net of SUMO; the folder refers to it.")],
    duration: Annotated[
        float, typer.Option(min=1.0, max=1e6, metavar="S", help="For how long vehicles depart.")
    ] = 300.0,
    period: Annotated[
        float | None,
        typer.Option(
            min=0.01, max=1e6, metavar="S", help="Mean time between two departures. [default: to suit the net]"
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, metavar="N", help="Of the random demand.")] = 1,
) -> None:
    """Make a scenario folder for a net: random demand, an example attack zone, and a commented gpsec.toml.

    \b
    Examples:
      gpsec new mytown --net town.net.xml
      netedit mytown/mytown.netecfg     (draw zones)
      gpsec run mytown
    """  # noqa: D301
    from gpsec.console.newscenario import new_scenario

    new_scenario(name, net, period, duration, seed)


@app.command()
def clean(
    folders: Annotated[
        list[Path] | None, typer.Argument(metavar="[DIR]...", help="Where to look. [default: here and in results]")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Remove it without asking.")] = False,
) -> int:
    """List what runs that were killed have left, and what caches hold of other versions; remove it if you say so.

    \b
    Examples:
      gpsec clean
      gpsec clean results/studies --yes
    """  # noqa: D301
    from gpsec.console.cleaning import clean as clean_up

    return clean_up(folders or [folder for folder in (Path(), Path("results")) if folder.is_dir()], yes=yes)


@app.command()
def schema() -> None:
    """Print the JSON Schema of gpsec.toml, with which an editor completes and checks it.

    \b
    Examples:
      gpsec schema > gpsec.schema.json     (and in gpsec.toml, as the first line: #:schema ./gpsec.schema.json)
    """  # noqa: D301
    import json

    from gpsec.scenario.schema import json_schema

    print(json.dumps(json_schema(), indent=2, ensure_ascii=False))


@app.command()
def train(
    seed: Annotated[int, typer.Option(metavar="N", help="Of traffic, noise and training.")] = 1,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where models go.")] = Path("models"),
    jobs: Annotated[int | None, typer.Option(min=1, metavar="N", help="Processes. [default: the cores]")] = None,
    networks: Annotated[
        str | None, typer.Option(metavar="A,B", help="Only these training networks. [default: all]")
    ] = None,
    detectors: Annotated[
        list[str] | None,
        typer.Option("--detector", metavar="X", help="Only this detector, and what shares its arrays; repeatable."),
    ] = None,
    profiles: Annotated[
        list[str] | None, typer.Option("--profile", metavar="P", help="Only this sensor profile; repeatable.")
    ] = None,
    part: _Part = None,
) -> None:
    """Train the learned detectors on benign runs and calibrate every threshold.

    \b
    Examples:
      gpsec train --seed 2 --out /tmp/models
      gpsec train --detector cusum --profile dsd
      gpsec train --part mine.py:OcSvm --detector oc_svm --profile carla
      gpsec train --networks mountain,suburb --out /tmp/models
      gpsec run scenarios/town --set detection.models=models
    """  # noqa: D301
    from time import perf_counter

    from rich.console import Console

    from gpsec.console.train import display
    from gpsec.training import NETWORKS
    from gpsec.training import train as train_models

    chosen = NETWORKS if networks is None else [name.strip() for name in networks.split(",")]
    console = Console()
    began = perf_counter()
    loaded = _load_parts(part)
    with display(console) as report:
        made = train_models(
            out,
            detectors=detectors or (),
            profiles=profiles or (),
            networks=chosen,
            parts=loaded,
            seed=seed,
            jobs=jobs,
            report=report,
        )
    console.print(f"{len(made)} models in {out} after {perf_counter() - began:.0f} s", highlight=False)


@app.command()
def paper(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where tables and runs go.")] = Path(
        "results/paper"
    ),
    folder: Annotated[
        Path | None, typer.Option("--dir", metavar="DIR", help="Where scenarios are. [default: those of gpsec]")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Short runs and one seed: wide intervals.")] = False,
    jobs: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Runs at a time. [default: the cores there are]")
    ] = None,
) -> None:
    """Re-create the paper's tables and figures, set beside its own numbers; goes on where an earlier call stopped.

    \b
    Examples:
      gpsec paper
      gpsec paper --quick --out /tmp/paper
    """  # noqa: D301
    from gpsec.console.paper import make_paper

    make_paper(out, folder or shipped.scenarios(), quick, jobs)
