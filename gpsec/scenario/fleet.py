"""The section `fleet`: who takes part, and with which sensors."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from gpsec.core.errors import shown
from gpsec.scenario import choices
from gpsec.scenario.base import Section, Unset
from gpsec.types.constants import ASSOCIATIONS


def _profile_shares(value: Any) -> Any:
    return {value: 1.0} if isinstance(value, str) else value


class CameraSection(Section):
    """What lane cameras are made of.

    Attributes:
        tape: recorded errors that are played back in the place of the profiles' noise, bias and outages: the name of a
            tape that gpsec comes with, or a file ending in `.npz`, relative to the scenario's folder, in a flag to the
            current one; unset takes the profiles' figures.
        visibility: `profile`: as each profile says; `clock`: markings are lost at random alone; `place`: also where too
            little of a line lies ahead, before stop lines, or behind another vehicle of the fleet. Lines are those of
            `NET.paint.csv` beside the net, as `gpsec import` writes it; without that file every lane has both. A tape
            has its losses in it: with one, `profile` is `clock`.
        source: `profile`: lanes are the true ones with the errors of profile or tape; `image`: for some of the vehicles
            they are found in rendered pictures of their view (needs the extra `image`), for the others as before.
        image_share: share of the vehicles that see pictures, drawn by seed and vehicle.
        image_vehicles: vehicles that see pictures in any case, by SUMO's ids.
        image_weather: of the pictures: `good`, `night`, `rain`, `rain-night`, `worn`, `shadows`, `noiseless`.
        image_memory_m: metres of way over which a lane is averaged, by odometer and gyro; unset takes single pictures.
        image_mounting_deg: standard deviation of how the camera is mounted, on each axis, which it does not know.
    """

    tape: Annotated[str | None, Unset] = None
    visibility: Literal["profile", "clock", "place"] = "profile"
    source: Literal["profile", "image"] = "profile"
    image_share: float = Field(0.0, ge=0.0, le=1.0)
    image_vehicles: tuple[str, ...] = Field((), strict=False)
    image_weather: str = "good"
    image_memory_m: Annotated[float | None, Unset] = Field(None, gt=0.0, le=200.0)
    image_mounting_deg: float = Field(0.1, ge=0.0, le=5.0)

    @field_validator("image_weather")
    @classmethod
    def _known_weather(cls, name: str) -> str:
        return choices.require_known("image_weather", name, choices.weathers())

    @model_validator(mode="after")
    def _somebody_sees_pictures(self) -> Self:
        somebody = self.image_share > 0.0 or bool(self.image_vehicles)
        if somebody and self.source != "image":
            raise ValueError("image_share and image_vehicles take source = 'image', found 'profile'")
        if not somebody and self.source == "image":
            raise ValueError("source = 'image' takes an image_share above 0, or image_vehicles, found neither")
        return self


class ReceiverSection(Section):
    """What GNSS receivers are made of.

    Attributes:
        tape: recorded errors that are played back in the place of the profiles' white noise, changes of the bias and
            outages, beside an offset that is constant for a journey; as for the camera.
    """

    tape: Annotated[str | None, Unset] = None


class FleetSection(Section):
    """Who takes part.

    Attributes:
        equipped_share: share of the vehicles that are automated, where their type does not say.
        profile: sensor profile (`gpsec list profiles`), or a table of shares that add up to 1, such as
            `{ dsd = 0.5, carla = 0.5 }`.
        association: how a vehicle knows which lane it is on: `tracked` from its own sensors; `nearest` takes the lane
            nearest to each fix, as in the paper; `oracle`, a bound, is told by the simulator.
        settle_s: seconds on the road before a vehicle is scored or attacked.
        camera, gnss: tables of their own, which all profiles of the run share.
    """

    equipped_share: float = Field(1.0, gt=0.0, le=1.0)
    profile: Annotated[Mapping[str, float], BeforeValidator(_profile_shares)] = Field({"carla": 1.0})
    association: str = ASSOCIATIONS[0]
    settle_s: float = Field(10.0, ge=0.0, le=600.0)
    camera: CameraSection = CameraSection()
    gnss: ReceiverSection = ReceiverSection()

    @model_validator(mode="before")
    @classmethod
    def _renamed(cls, raw: Any) -> Any:
        if isinstance(raw, dict) and "matching" in raw:
            raise ValueError("'matching' is now called 'association': `tracked`, `nearest`, or `oracle`")
        return raw

    @field_validator("association")
    @classmethod
    def _known_association(cls, name: str) -> str:
        return choices.require_known("association", name, ASSOCIATIONS)

    @field_validator("profile")
    @classmethod
    def _known_and_whole(cls, shares: Mapping[str, float]) -> Mapping[str, float]:
        for name, share in shares.items():
            choices.require_known("profile", name, choices.profiles())
            if share <= 0.0:
                raise ValueError(f"expected a share above 0 for '{shown(name)}', found {share:g}")
        total = sum(shares.values())
        if abs(total - 1.0) > 1e-6:
            raise ValueError(f"expected shares that add up to 1, found {total:g}")
        return shares
