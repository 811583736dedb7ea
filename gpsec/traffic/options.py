"""Turns any SUMO configuration into arguments for libsumo that are safe, quiet and reproducible."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path

from gpsec.core.errors import GpsecError, shown
from gpsec.traffic.config import SumoConfig, read_config
from gpsec.traffic.input_checks import checked_input_files
from gpsec.traffic.input_files import input_files
from gpsec.traffic.inputs import first_match
from gpsec.traffic.optiontable import SumoOption, sumo_options_by_name

DEFAULT_STEP_S = 0.1
MIN_STEP_S = 0.001  # SUMO counts milliseconds
MAX_STEP_S = 0.2
MIN_LATERAL_RESOLUTION_M, MAX_LATERAL_RESOLUTION_M = 0.1, 10.0
DEFAULT_LATERAL_RESOLUTION_M = 0.8

# Options of these topics neither change the traffic nor are wanted in-process.
_DROPPED_TOPICS = {"configuration", "output", "traci_server", "gui_only"}
# Of the topic `report` only these are kept: how strictly the inputs are read. Other values than these two would fetch
# schemas from wherever a file says.
_VALIDATION = ("xml-validation", "xml-validation.net", "xml-validation.routes")
_VALIDATED_HERE = ("never", "local")
# Set anew from the run.
_SET_HERE = {"step-length", "lateral-resolution", "seed", "random"}
_QUIET = {
    "no-step-log": "true",
    "no-warnings": "true",  # on the terminal; the error log still gets them
    "duration-log.disable": "true",
    "aggregate-warnings": "10",
}
# What the closed loop needs, and why.
_CLOSED_LOOP = {
    "time-to-teleport": ("-1", "a wreck and the jam behind it stay where they are"),
    "thread-rngs": ("100000", "each lane has random numbers of its own, so that one car changes only those near it"),
    "collision.action": ("warn", "what touches goes on, since gpsec sees to wrecks itself"),
    "collision.mingap-factor": ("0", "a gap that is small is no collision"),
}
# SUMO refuses sublanes beside these; SL2015 is the only model that knows them.
_LANE_MODELS_WITHOUT_SUBLANES = rb"""laneChangeModel\s*=\s*["'](LC2013\w*|DK2008)["']"""


@dataclass(frozen=True)
class SumoOptions:
    """How to start a simulation.

    Attributes:
        config: absolute path of the configuration.
        arguments: for ``libsumo.start`` behind the program name; the session adds where outputs go.
        net_file: absolute path.
        route_files, additional_files: absolute paths.
        begin_s: simulated time at which the simulation begins.
        end_s: time at which it ends, None where the scenario leaves that open.
        step_s: length of a step.
        lateral_resolution_m: width of a sublane, 0 where vehicles change lanes at once.
        seed: of SUMO's random numbers.
        notes: what was changed against the configuration, one sentence each.
    """

    config: Path
    arguments: tuple[str, ...]
    net_file: Path
    route_files: tuple[Path, ...]
    additional_files: tuple[Path, ...]
    begin_s: float
    end_s: float | None
    step_s: float
    lateral_resolution_m: float
    seed: int
    notes: tuple[str, ...]


def resolve_options(
    config_file: Path,
    *,
    seed: int,
    step_s: float | None = None,
    lateral_resolution_m: float | None = None,
    begin_s: float | None = None,
    closed_loop: bool = False,
) -> SumoOptions:
    """Return how to run the configuration `config_file` in-process, without it writing beside itself.

    Args:
        config_file: any ``.sumocfg``, also one made for sumo-gui.
        seed: of the run; SUMO gets it modulo 2³¹.
        step_s: None takes the scenario's step, lowered to 0.1 s where it is longer.
        lateral_resolution_m: None takes the scenario's own or 0.8 m, 0 switches sublanes off.
        begin_s: simulated time to begin at; None takes the scenario's own.
        closed_loop: vehicles are to be steered; sets options that this needs, each with a note.

    Raises:
        GpsecError: a file is missing, an option is unknown, sublanes are off in closed loop, or `step_s` is outside
            (0, 0.2].
    """
    config = read_config(config_file)
    notes: list[str] = []
    files = checked_input_files(config)
    step = _step(config, step_s, notes)
    lateral = _lateral_resolution(config, files, lateral_resolution_m, notes)
    if closed_loop and lateral <= 0.0:
        raise GpsecError(
            f"{config.path}: closed loop: expected sublanes, found none; traffic.lateral_resolution_m ="
            f" {DEFAULT_LATERAL_RESOLUTION_M:g} turns them on, where the scenario's lane-change model has them"
        )
    sumo_seed = seed % 2**31
    end = config.seconds("end", -1.0)
    begin = _begin(config, begin_s, end)
    chosen = {
        **_kept_values(config, files, notes),
        **({} if begin_s is None else {"begin": f"{begin:.10g}"}),
        "step-length": f"{step:g}",
        "seed": str(sumo_seed),
        **_QUIET,
        **({"lateral-resolution": f"{lateral:g}"} if lateral > 0.0 else {}),
        **(_closed_loop(config, notes) if closed_loop else {}),
    }
    return SumoOptions(
        config=config.path,
        arguments=tuple(part for name, value in chosen.items() for part in (f"--{name}", value)),
        net_file=files["net-file"][0],
        route_files=tuple(files["route-files"]),
        additional_files=tuple(files["additional-files"]),
        begin_s=begin,
        end_s=end if end >= 0.0 else None,
        step_s=step,
        lateral_resolution_m=lateral,
        seed=sumo_seed,
        notes=tuple(notes),
    )


def _closed_loop(config: SumoConfig, notes: list[str]) -> dict[str, str]:
    """Return the options of the closed loop, and note what is not as the configuration has it."""
    for name, (value, reason) in _CLOSED_LOOP.items():
        if config.values.get(name) != value:
            notes.append(f"closed loop: {name} set to {value}: {reason}")
    notes.append("closed loop: lcSigma set to 0: wander in the lane draws from one stream for all vehicles")
    notes.append(
        "closed loop: lcMaxSpeedLatStanding set to 0 and lcMaxSpeedLatFactor to 0.27: who stands does not slide across"
        " the road"
    )
    notes.append(
        "closed loop: junctionModel.ignoreIDs set where who is held still has stood for 10 s near a junction, out of a"
        " vehicle's way: it would give way to a wreck for ever"
    )
    return {name: value for name, (value, _) in _CLOSED_LOOP.items()}


def _begin(config: SumoConfig, asked_s: float | None, end_s: float) -> float:
    if asked_s is None:
        return config.seconds("begin", 0.0)
    if 0.0 <= end_s <= asked_s:
        raise GpsecError(
            f"traffic.begin_s: expected less than the end in {config.path}, {end_s:g} s, found {asked_s:g} s"
        )
    return asked_s


def _step(config: SumoConfig, asked_s: float | None, notes: list[str]) -> float:
    if asked_s is not None:
        if not MIN_STEP_S <= asked_s <= MAX_STEP_S:
            raise GpsecError(
                f"traffic.step_s: expected 0.001 to {MAX_STEP_S:g} s, found {asked_s:g} s, for which the filters are "
                f"not valid; the usual one is {DEFAULT_STEP_S:g} s"
            )
        return round(asked_s, 3)
    own_s = config.seconds("step-length", 1.0)
    if not MIN_STEP_S <= own_s < inf:
        raise GpsecError(
            f"{config.path}: option 'step-length': expected {MIN_STEP_S:g} s or more, found "
            f"'{shown(config.values['step-length'])}'; the usual one is {DEFAULT_STEP_S:g} s"
        )
    if own_s > DEFAULT_STEP_S:
        keeps = "keeps the scenario's own" if own_s <= MAX_STEP_S else "comes closest to it"
        notes.append(
            f"step-length lowered from {own_s:g} to {DEFAULT_STEP_S:g} s; "
            f"traffic.step_s = {min(own_s, MAX_STEP_S):g} {keeps}"
        )
        return DEFAULT_STEP_S
    return own_s


def _lateral_resolution(
    config: SumoConfig, files: dict[str, list[Path]], asked_m: float | None, notes: list[str]
) -> float:
    if asked_m is not None:
        if not 0.0 <= asked_m <= MAX_LATERAL_RESOLUTION_M:
            raise GpsecError(f"lateral resolution {asked_m:g} m: expected 0 (off) to 10 m")
        return asked_m
    own_m = config.number("lateral-resolution", -1.0)
    if not (own_m <= 0.0 or MIN_LATERAL_RESOLUTION_M <= own_m <= MAX_LATERAL_RESOLUTION_M):
        raise GpsecError(
            f"{config.path}: option 'lateral-resolution': expected 0 (off), or {MIN_LATERAL_RESOLUTION_M:g} to "
            f"{MAX_LATERAL_RESOLUTION_M:g} m, found '{shown(config.values['lateral-resolution'])}'"
        )
    if own_m > 0.0:
        return own_m
    if config.seconds("lanechange.duration", 0.0) > 0.0:
        notes.append("lateral-resolution left off: the scenario sets lanechange.duration, SUMO takes only one")
        return 0.0
    for path in input_files((*files["additional-files"], *files["route-files"])):
        if model := first_match(path, _LANE_MODELS_WITHOUT_SUBLANES):
            notes.append(f"lateral-resolution left off: {path.name} uses lane-change model {shown(model)}")
            return 0.0
    notes.append(
        f"lateral-resolution set to {DEFAULT_LATERAL_RESOLUTION_M:g} m; traffic.lateral_resolution_m = 0 keeps the "
        "scenario's own lane changes, which take one step"
    )
    return DEFAULT_LATERAL_RESOLUTION_M


def _kept_values(config: SumoConfig, files: dict[str, list[Path]], notes: list[str]) -> dict[str, str]:
    if config.is_on("mesosim"):
        raise GpsecError(
            f"{config.path}: mesosim is on: expected a microscopic simulation, meso has no lateral positions"
        )
    kept: dict[str, str] = {}
    for option, value in _given(config):
        if option.topic in {*_DROPPED_TOPICS, "report"} or option.name in _SET_HERE or _is_written(option):
            continue
        if option.is_file:
            paths = files.get(option.name) or config.paths(option.name)
            value = ",".join(str(path) for path in paths)
        if value:
            kept[option.name] = value
    kept |= _validation(config, notes)
    if config.gui_only:
        notes.append(f"ignored (sumo-gui only): {shown(', '.join(config.gui_only))}")
    if outputs := [option.name for option, value in _given(config) if value and _is_output(option)]:
        notes.append(f"outputs left out: {', '.join(outputs)}")
    if config.is_on("random"):
        notes.append("option random ignored: the seed is the run's")
    return kept


def _given(config: SumoConfig) -> Iterator[tuple[SumoOption, str]]:
    known = sumo_options_by_name()
    for name, value in config.values.items():
        yield known[name], value


def _is_output(option: SumoOption) -> bool:
    return (option.is_file and option.topic in {"output", "report"}) or _is_written(option)


def _is_written(option: SumoOption) -> bool:
    """Return whether an option of a device, such as ``device.ssm.file``, names what is written."""
    return option.name.endswith((".output", ".file"))


def _validation(config: SumoConfig, notes: list[str]) -> dict[str, str]:
    """Return how strictly inputs are read, in such a way that no schema is fetched from elsewhere."""
    known = sumo_options_by_name()
    asked = {name: config.values.get(name) or known[name].default for name in _VALIDATION}
    if fetching := [name for name, value in asked.items() if value not in _VALIDATED_HERE]:
        notes.append(f"{', '.join(fetching)} set to local: schemas are not fetched from the network")
    return {name: value if value in _VALIDATED_HERE else "local" for name, value in asked.items()}
