"""What a run was and what it cost, for whoever wants to repeat it."""

import json
import platform
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from gpsec.attacks.schedule import Plan
from gpsec.core.version import __version__
from gpsec.outcomes.digests import DIGESTS, table_digests
from gpsec.outcomes.tables import whole
from gpsec.pipeline.build import Ground
from gpsec.pipeline.fingerprint import fingerprint, versions
from gpsec.scenario import Scenario
from gpsec.traffic.source import Frame


@dataclass
class Counts:
    """How much a run did, and how long it took.

    Attributes:
        steps: of the simulation.
        vehicles: distinct vehicles of the fleet; one that goes on after a jump or a teleport counts again.
        resumed: those that went on as ``id#2``, ``id#3``, …
        vehicle_steps, track_steps: sums over the steps of vehicles of the fleet and of tracks.
        against_steps: those vehicle steps that were left out, on a lane that leads against the vehicle.
        road_steps: sum over the steps of all vehicles in the simulation, equipped or not.
        peak_vehicles: most vehicles of the fleet at once; peak_on_road: most in the simulation, equipped or not.
        sumo_s, read_s: wall-clock seconds in SUMO's steps, and in reading them.
        compile_s: wall-clock seconds of compiling kernels inside the loop; they count for no stage.
        right_lane_share: share of the honest steps on roads on which each profile believed to be on the right lane.
        pixels: which vehicles saw pictures, how many, and in how many there was a lane; empty where nobody did.
        closed_loop: figures of a world, empty in open loop.
        loop_s, total_s: wall-clock seconds of the loop, and of everything from loading to the tables.

    """

    steps: int = 0
    vehicles: int = 0
    resumed: int = 0
    vehicle_steps: int = 0
    track_steps: int = 0
    against_steps: int = 0
    road_steps: int = 0
    peak_vehicles: int = 0
    peak_on_road: int = 0
    sumo_s: float = 0.0
    read_s: float = 0.0
    compile_s: float = 0.0
    right_lane_share: dict[str, float] = field(default_factory=dict)
    pixels: Mapping[str, Any] = field(default_factory=dict)
    closed_loop: Mapping[str, Any] = field(default_factory=dict)
    loop_s: float = 0.0
    total_s: float = 0.0

    def add(self, frame: Frame, tracks: int, against: int) -> None:
        """Count one step, with the number of tracks and of vehicles whose lane leads against them."""
        self.steps += 1
        self.vehicles += len(frame.departures)
        self.resumed += sum(departure.first_id != departure.vehicle_id for departure in frame.departures)
        self.vehicle_steps += len(frame.rows)
        self.road_steps += frame.on_road
        self.track_steps += tracks
        self.against_steps += against
        self.peak_vehicles = max(self.peak_vehicles, len(frame.rows))
        self.peak_on_road = max(self.peak_on_road, frame.on_road)


def write_manifest(
    folder: Path,
    scenario: Scenario,
    ground: Ground,
    plans: Sequence[Plan],
    counts: Counts,
    stages_s: Mapping[str, float],
    notes: Sequence[str],
    warnings: Sequence[str],
) -> None:
    """Write `manifest.json`, after all tables; `notes` is what the user was told, `warnings` what SUMO said."""
    figures = {key: round(value, 4) if isinstance(value, float) else value for key, value in asdict(counts).items()}
    manifest: dict[str, Any] = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "gpsec_version": __version__,
        "git_commit": git_commit(),
        "fingerprint": fingerprint(scenario),
        "python_version": platform.python_version(),
        "versions": versions(),
        "configuration": scenario.stated(),
        "step_s": ground.options.step_s,
        "lateral_resolution_m": ground.options.lateral_resolution_m,
        "profiles": list(ground.choice.profiles),
        "plans": [_plan(plan) for plan in plans],
        "notes": list(notes),
        "sumo_warnings": list(warnings),
        **figures,
        "stages_s": {stage: round(seconds, 4) for stage, seconds in stages_s.items()},
        "stages_us_per_vehicle_step": {
            stage: round(seconds / max(counts.vehicle_steps, 1) * 1e6, 4) for stage, seconds in stages_s.items()
        },
        DIGESTS: table_digests(folder),
    }
    with whole(folder / "manifest.json") as path:
        path.write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")


def _plan(plan: Plan) -> dict[str, Any]:
    """Return all that a plan depends on, drawn zones and spoofers in traffic included."""
    stated = plan.config.model_dump(mode="json")
    if plan.zone is not None and plan.zone.moves:
        stated |= {"radius_m": plan.zone.radius_m, "hold_s": plan.zone.hold_s, "moves": True}
    elif plan.zone is not None:
        stated |= {"shape_m": plan.zone.shape_m.tolist(), "radius_m": plan.zone.radius_m}
    return stated


def git_commit() -> str | None:
    """Return the commit of the checkout that this code lies in, with a mark where it was changed; None outside one."""
    here = Path(__file__).resolve().parent
    try:
        _git(here, "ls-files", "--error-unmatch", __file__)  # an environment may lie in somebody else's checkout
        commit = _git(here, "rev-parse", "HEAD")
        changed = _git(here, "status", "--porcelain", "--untracked-files=no", "--", str(here.parent))
    except (OSError, subprocess.CalledProcessError):
        return None
    return f"{commit}+changes" if changed else commit


def _git(folder: Path, *arguments: str) -> str:
    done = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=True)
    return done.stdout.strip()
