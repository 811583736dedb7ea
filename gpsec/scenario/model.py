"""One scenario, resolved: everything that a run depends on."""

import re
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    Field,
    FieldSerializationInfo,
    ValidationInfo,
    field_serializer,
    field_validator,
    model_validator,
)

from gpsec.attacks.plans import MAX_TIME_S, PlanConfig
from gpsec.core.errors import nearest, shown
from gpsec.scenario import choices
from gpsec.scenario.base import Section, Unset
from gpsec.scenario.closed_loop import ClosedLoopSection
from gpsec.scenario.defaults import default_list
from gpsec.scenario.detection import Defence, DetectionSection
from gpsec.scenario.fleet import FleetSection
from gpsec.scenario.mismatch import WorldSection
from gpsec.scenario.outside import load_parts
from gpsec.scenario.paths import expand, portable
from gpsec.scenario.sections import LocalizationSection, OutcomesSection, TrafficSection
from gpsec.types.points import HEADLINE_RATE, point_name

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
MAX_NAME = 100  # file systems end at 255 bytes, and folders in the making have longer names
ALLOW_CODE = "allow_code"
"""Key of a validation context: the code that the scenario names may be run."""
_HERE = "here"


class Scenario(Section):
    """What is run: traffic, fleet, attack plans, defences, and how results are summed up.

    A run is a pure function of this object. `model_dump_json` gives JSON that `model_validate_json` takes back, in any
    folder: paths in it are absolute, or begin with `$SUMO_HOME/` or `$GPSEC/`, which are there on every machine that
    has gpsec. Code that it names as `parts` is refused, unless it is loaded already or the context says so:
    ``Scenario.model_validate_json(text, context={"allow_code": True})``.

    Attributes:
        name: of the scenario, in every table and as a folder under `results/`: letters, digits, `.`, `_`, `-`; unset
            takes the folder's or the sumocfg's.
        sumocfg: the SUMO configuration, relative to this file; may begin with `$SUMO_HOME/`, that SUMO where it is of
            the tested version, otherwise the one that is installed with gpsec; unset takes the only one in the folder.
        seed: of SUMO and of all noise; the same seed gives the same results.
        duration_s: simulated seconds, counted from the first departure where that comes later; unset runs to the end in
            the sumocfg.
        threads: for the security layer of one scenario; results do not depend on it.
        engine: `batched` kernels, or `reference`, the second implementation, one vehicle at a time, for small fleets.
        log_steps: also write every step of every track to `steps.parquet`.
        log_vehicles: write `steps.parquet` for these vehicles only, by SUMO's ids.
        parts: attacks, detectors, responses and sensor profiles from outside gpsec, by `FILE.py:Name`,
            `package.module:Name` or `FILE.toml` (a profile); files are relative to this one. What is code is refused
            without `--allow-code`, since a scenario may come from somebody else.
        fleet, world, traffic, detection, localization, outcomes, closed_loop: the sections of that name.
        defences: D of them; the first is never+none, the undefended vehicle.
        plans: attack plans; *no attack* comes before the first of them and is not listed.
    """

    name: str
    sumocfg: Annotated[Path, Field(strict=False)]
    seed: int = Field(1, ge=0, le=2**31 - 1)
    duration_s: Annotated[float | None, Unset] = Field(None, gt=0.0, le=MAX_TIME_S)
    threads: int = Field(1, ge=1, le=256)
    engine: Literal["batched", "reference"] = "batched"
    log_steps: bool = False
    log_vehicles: tuple[str, ...] = Field((), strict=False)
    parts: tuple[str, ...] = Field((), strict=False)
    fleet: FleetSection = FleetSection()
    world: WorldSection = WorldSection()
    traffic: TrafficSection = TrafficSection()
    detection: DetectionSection = DetectionSection()
    localization: LocalizationSection = LocalizationSection()
    outcomes: OutcomesSection = OutcomesSection()
    closed_loop: ClosedLoopSection = ClosedLoopSection()
    defences: tuple[Defence, ...] = Field(strict=False)
    plans: tuple[PlanConfig, ...] = Field(strict=False)

    @model_validator(mode="before")
    @classmethod
    def _fill_lists(cls, raw: Any) -> Any:
        if not isinstance(raw, dict):
            return raw
        return raw | {key: default_list(key, raw) for key in ("defences", "plans") if key not in raw}

    @field_validator("parts")
    @classmethod
    def _loaded(cls, references: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
        """Refuse code that nobody has loaded: who loads it has chosen it."""
        allowed = bool((info.context or {}).get(ALLOW_CODE))
        return load_parts(references, Path.cwd(), allow_code=allowed) if references else ()

    @field_validator("sumocfg", mode="before")
    @classmethod
    def _expanded(cls, path: Any) -> Any:
        return str(expand(path, Path.cwd())) if isinstance(path, str) else path

    @field_validator("name")
    @classmethod
    def _usable_as_folder(cls, name: str) -> str:
        if not NAME.fullmatch(name):
            raise ValueError(f"expected letters, digits, '.', '_' and '-' only, found '{shown(name)}'")
        if len(name) > MAX_NAME:
            raise ValueError(f"expected at most {MAX_NAME} characters, found {len(name)}")
        return name

    @field_validator("defences")
    @classmethod
    def _undefended_first(cls, defences: tuple[Defence, ...]) -> tuple[Defence, ...]:
        names = [defence.name for defence in defences]
        for position, name in enumerate(names):
            if name in names[:position]:
                raise ValueError(f"'{shown(name)}' is listed twice")
        undefended = Defence(detector="never", response="none")
        return (undefended, *(defence for defence in defences if defence != undefended))

    @field_validator("plans")
    @classmethod
    def _distinct_names(cls, plans: tuple[PlanConfig, ...]) -> tuple[PlanConfig, ...]:
        names = [plan.name for plan in plans]
        for position, name in enumerate(names):
            if name in names[:position]:
                raise ValueError(f"two plans are called '{shown(name)}'; give one of them a `name`")
        return plans

    @model_validator(mode="after")
    def _defences_have_their_detector(self) -> Self:
        scored = self.detection.detectors
        for defence in self.defences:
            if defence.detector not in (*choices.BOUNDS, *scored):
                raise ValueError(
                    f"defences: '{shown(defence.name)}' needs a detector that detection.detectors does not list"
                    f" (listed: {', '.join(scored) or 'none'}); list it there, or state `defences` that do without it"
                )
        return self

    @model_validator(mode="after")
    def _plans_target_detectors_of_the_run(self) -> Self:
        scored = [point_name(*point) for point in self.points() if point[0] not in choices.BOUNDS]
        for plan in self.plans:
            known = plan.parameters.known()
            for target in () if known is None else known.targets:
                if target not in scored:
                    raise ValueError(
                        f"plan '{shown(plan.name)}': target: no detector of the run is called '{shown(target)}';"
                        f" {nearest(target, scored)}"
                    )
        return self

    def points(self) -> tuple[tuple[str, str], ...]:
        """Return detector and rate of all operating points, those of one detector side by side."""
        found: list[tuple[str, str]] = []
        for name in (*self.detection.detectors, *choices.BOUNDS):
            own = [defence.rate for defence in self.defences if defence.detector == name]
            if not choices.has_rate(name):
                wanted = own[:1] if name in choices.BOUNDS else [HEADLINE_RATE]
            else:
                wanted = [*self.detection.rates, *own]
            found += [(name, rate) for rate in dict.fromkeys(wanted)]
        return tuple(found)

    def stated(self) -> dict[str, Any]:
        """Return it as plain JSON for a manifest; paths below the current folder are relative to that."""
        return self.model_dump(mode="json", context={_HERE: Path.cwd()})

    @field_serializer("parts")
    def _portable_parts(self, references: tuple[str, ...], info: FieldSerializationInfo) -> list[str]:
        from gpsec.scenario.parts import relocate

        return [relocate(reference, lambda place: portable(Path(place), _here(info))) for reference in references]

    @field_serializer("sumocfg")
    def _portable_path(self, path: Path, info: FieldSerializationInfo) -> str:
        return portable(path, _here(info))


def _here(info: FieldSerializationInfo) -> Path | None:
    return info.context.get(_HERE) if isinstance(info.context, dict) else None
