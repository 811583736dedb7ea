"""What a report reads of the manifest of a scenario, and of what type it has to be."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gpsec.core.errors import GpsecError, shown
from gpsec.types.constants import MANIFEST

_Number = Annotated[float, Field(allow_inf_nan=False, ge=-1e15, le=1e15)]
_Count = Annotated[int, Field(ge=0, le=2**53)]
_Share = Annotated[float, Field(ge=0.0, le=1.0)]


class _Part(BaseModel):
    """A part of a manifest; what else is in it is nobody's business."""

    model_config = ConfigDict(strict=True, extra="allow")


class _Plan(_Part):
    name: str
    attack: str
    share: _Share
    parameters: dict[str, Any]


class _Fleet(_Part):
    equipped_share: _Share
    association: str
    settle_s: _Number


class _Detection(_Part):
    rates: list[str]


class _Localization(_Part):
    hold_s: _Number
    rejoin_s: _Number


class _Outcomes(_Part):
    bootstrap: Annotated[int, Field(ge=1, le=100_000)]
    confidence: Annotated[float, Field(gt=0.0, lt=1.0)]


class _Configuration(_Part):
    sumocfg: str
    engine: str
    fleet: _Fleet
    detection: _Detection
    localization: _Localization
    outcomes: _Outcomes


class _Stated(_Part):
    scenario: str
    seed: _Count
    gpsec_version: str
    git_commit: str | None
    versions: dict[str, str]
    configuration: _Configuration
    step_s: Annotated[float, Field(gt=0.0, le=10.0)]
    profiles: list[str]
    plans: list[_Plan]
    notes: list[str]
    steps: _Count
    vehicles: _Count
    vehicle_steps: _Count
    peak_vehicles: _Count
    sumo_s: _Number
    stages_s: dict[str, _Number]


class _Unfinished(_Part):
    scenario: str
    reason: str


def check_stated(folder: Path, manifest: dict[str, Any]) -> None:
    """Refuse a manifest without what a report reads, or with that of another type.

    Raises:
        GpsecError: naming the key.
    """
    parts: list[tuple[type[_Part], str, Any]] = [
        (_Stated, f"scenarios.{place}", stated) for place, stated in enumerate(manifest["scenarios"])
    ]
    unfinished = manifest.get("unfinished", [])
    if not isinstance(unfinished, list):
        raise GpsecError(f"{folder / MANIFEST}: unfinished: expected a list, found {shown(unfinished)}")
    parts += [(_Unfinished, f"unfinished.{place}", entry) for place, entry in enumerate(unfinished)]
    for kind, where, content in parts:
        try:
            kind.model_validate(content)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            key = ".".join([where, *map(shown, first["loc"])])
            wrong = first["msg"][:1].lower() + first["msg"][1:]
            found = "" if first["type"] == "missing" else f", found {shown(first['input'])}"
            raise GpsecError(f"{folder / MANIFEST}: {key}: {wrong}{found}") from None
    for place, stated in enumerate(manifest["scenarios"]):
        if "libsumo" not in stated["versions"]:
            where = f"scenarios.{place}.versions"
            raise GpsecError(f"{folder / MANIFEST}: {where}: expected the one of libsumo, found none")
