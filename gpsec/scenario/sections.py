"""The sections of `gpsec.toml`: their keys, types, bounds and defaults."""

from collections.abc import Mapping
from math import hypot
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from gpsec.attacks.plans import MAX_TIME_S
from gpsec.core.errors import shown
from gpsec.scenario import choices
from gpsec.scenario.base import Section, Unset
from gpsec.types.camera import NO_MISTAKES
from gpsec.types.constants import ASSOCIATIONS
from gpsec.types.points import HEADLINE_RATE, PER_SAMPLE, point_name

MAX_MAP_ERROR_M = 2.0
# Strict models take a tuple only; TOML and JSON give lists.
Lax = Field(strict=False)


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


class WorldSection(Section):
    """By what the world differs from what filters and detectors take it to be; nothing, unless said.

    Attributes:
        gnss_white_factor: on the white noise of fixes.
        gnss_slow_factor: on the slow error of fixes.
        camera_factor: on the camera's noise, slow error and mounting offset; the σ that it states stays.
        odometer_factor: on the odometer's white noise and scale error.
        gyro_factor: on the gyro's angle random walk and bias.
        heading_factor: on white noise and slow error of the heading sensor.
        gnss_common_share: share of the variance of the slow GNSS error that all vehicles have in common.
        map_shift_east_m, map_shift_north_m: by which the maps in vehicles are off.
        map_field_m: standard deviation, on each axis, of a map error that varies from place to place.
        map_field_length_m: metres over which that error stays alike (correlation length of a Gaussian).
        map_road_m: standard deviation of a map error across the road, drawn for each road.
        camera_hysteresis_m: the camera keeps to a lane until the rear axle is beyond the line by this much.
        camera_late_s: seconds for which it then still keeps to it.
        camera_wrong_per_h: times in an hour that the camera begins to show the lane beside its own.
        camera_wrong_s: seconds that it does so.
        camera_blind_m: the camera shows no lane while a line of it is nearer to the rear axle than this.
        multipath_share: share of the road's length on which fixes are off by multipath; needs `multipath_m`.
        multipath_m: size of that error, whose direction is drawn for each place.
        multipath_length_m: side of the squares that these places are.
    """

    gnss_white_factor: float = Field(1.0, ge=0.0, le=100.0)
    gnss_slow_factor: float = Field(1.0, ge=0.0, le=100.0)
    camera_factor: float = Field(1.0, ge=0.0, le=100.0)
    odometer_factor: float = Field(1.0, ge=0.0, le=100.0)
    gyro_factor: float = Field(1.0, ge=0.0, le=100.0)
    heading_factor: float = Field(1.0, ge=0.0, le=100.0)
    gnss_common_share: float = Field(0.0, ge=0.0, le=1.0)
    map_shift_east_m: float = Field(0.0, ge=-2.0, le=2.0)
    map_shift_north_m: float = Field(0.0, ge=-2.0, le=2.0)
    map_field_m: float = Field(0.0, ge=0.0, le=2.0)
    map_field_length_m: float = Field(200.0, ge=20.0, le=1e6)
    map_road_m: float = Field(0.0, ge=0.0, le=2.0)
    camera_hysteresis_m: float = Field(NO_MISTAKES.hysteresis_m, ge=0.0, le=2.0)
    camera_late_s: float = Field(0.0, ge=0.0, le=60.0)
    camera_wrong_per_h: float = Field(0.0, ge=0.0, le=3600.0)
    camera_wrong_s: float = Field(NO_MISTAKES.wrong_s, gt=0.0, le=60.0)
    camera_blind_m: float = Field(0.0, ge=0.0, le=2.0)
    multipath_share: float = Field(0.0, ge=0.0, le=1.0)
    multipath_m: float = Field(0.0, ge=0.0, le=100.0)
    multipath_length_m: float = Field(50.0, ge=5.0, le=10_000.0)

    @model_validator(mode="after")
    def _means_something(self) -> Self:
        parts = (self.map_shift_east_m, self.map_shift_north_m, self.map_field_m, self.map_road_m)
        total_m = hypot(*parts)
        # Filters would be on another lane than the vehicle.
        if total_m > MAX_MAP_ERROR_M:
            raise ValueError(f"expected a map error of at most {MAX_MAP_ERROR_M:g} m in all, found {total_m:.3g}")
        if (self.multipath_share > 0.0) != (self.multipath_m > 0.0):
            raise ValueError(
                "expected multipath_share and multipath_m together,"
                f" found {self.multipath_share:g} and {self.multipath_m:g}"
            )
        return self

    def stated(self) -> dict[str, float]:
        """Return the keys that are not as filters and detectors take them to be."""
        return {key: value for key, value in self if value != type(self).model_fields[key].default}


class TrafficSection(Section):
    """How SUMO is run.

    Attributes:
        begin_s: simulated time at which SUMO begins, such as that of the rush hour; unset takes the sumocfg's.
        step_s: seconds of a step, since the filters are not valid for long ones; unset takes 0.1, or the sumocfg's
            where that is shorter.
        lateral_resolution_m: metres of SUMO's sublanes, at least 0.1; unset takes the sumocfg's, or 0.8 where it has
            none; 0 turns them off, and lane changes then take one step.
    """

    begin_s: Annotated[float | None, Unset] = Field(None, ge=0.0, le=MAX_TIME_S)
    # The filters are not valid for longer steps.
    step_s: Annotated[float | None, Unset] = Field(None, ge=0.001, le=0.2)
    lateral_resolution_m: Annotated[float | None, Unset] = Field(None, ge=0.0, le=5.0)

    @field_validator("lateral_resolution_m")
    @classmethod
    def _not_too_fine(cls, width_m: float | None) -> float | None:
        # SUMO would go through thousands of sublanes for every vehicle.
        if width_m is not None and 0.0 < width_m < 0.1:
            raise ValueError(f"expected 0 (off), or 0.1 to 5, found {width_m:g}")
        return width_m


class DetectionSection(Section):
    """Who watches.

    Attributes:
        detectors: those that are scored (`gpsec list detectors`), in the order of the tables.
        rates: false-alarm rates, per vehicle-hour or per sample, at which each of them is scored, one at least; see
            `defences.rate`.
        monitor: how far the monitor of `joint` and its like adapts to sensors that are noisier than stated: `R2` where
            an attacker counts, `R3`, further, where maps are poor.
        models: folder of the models, as `gpsec train --out` wrote it; relative to the scenario's folder, in a flag to
            the current one; unset takes those that gpsec comes with.
    """

    detectors: tuple[str, ...] = Field(
        ("chi_square", "cusum", "isolation_forest", "lstm_glr", "innovation", "joint"), strict=False
    )
    rates: tuple[str, ...] = Field((HEADLINE_RATE, PER_SAMPLE), strict=False)
    monitor: Literal["R2", "R3"] = "R2"
    models: Annotated[str | None, Unset] = None

    @field_validator("detectors")
    @classmethod
    def _known_once(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for position, name in enumerate(names):
            choices.require_known("detector", name, choices.detectors())
            if name in names[:position]:
                raise ValueError(f"'{shown(name)}' is listed twice")
        return names

    @field_validator("rates")
    @classmethod
    def _calibrated(cls, rates: tuple[str, ...]) -> tuple[str, ...]:
        if not rates:
            raise ValueError(f"expected at least one rate, such as '{HEADLINE_RATE}', found none")
        for position, rate in enumerate(rates):
            choices.require_rate(rate)
            if rate in rates[:position]:
                raise ValueError(f"'{shown(rate)}' is listed twice")
        return rates


class Defence(Section):
    """A detector and what the vehicle does on its alarm.

    Attributes:
        detector: one of `detection.detectors`; or `told`, which is told at once when an attack begins and ends; or
            `never`, which gives no alarm.
        response: what replaces GNSS while the alarm lasts (`gpsec list responses`).
        rate: of the detector's false alarms, which its threshold is calibrated to: `0.1/h`, ten vehicle-hours for each,
            is what one would drive with; `1e-3/sample` is what the paper's tables are set beside. In tables another
            rate than `0.1/h` is part of the name: `lstm@1e-3/sample+ukf`.
    """

    detector: str
    response: str
    rate: str = HEADLINE_RATE

    @property
    def point(self) -> str:
        """Name of its detector at its rate."""
        return point_name(self.detector, self.rate)

    @property
    def name(self) -> str:
        """Name of the defence in tables: ``detector+response``, or ``detector@rate+response``."""
        return f"{self.point}+{self.response}"

    @field_validator("rate")
    @classmethod
    def _calibrated(cls, rate: str) -> str:
        return choices.require_rate(rate)

    @model_validator(mode="after")
    def _rate_means_something(self) -> Self:
        if self.rate != HEADLINE_RATE and not choices.has_rate(self.detector):
            raise ValueError(f"'{shown(self.detector)}' has no calibrated threshold, and so no rate")
        return self

    @field_validator("detector")
    @classmethod
    def _known_detector(cls, name: str) -> str:
        if name == "oracle":
            raise ValueError("the detector 'oracle' is called 'told' now; expected 'told'")
        return choices.require_known("detector", name, [*choices.BOUNDS, *choices.detectors()])

    @field_validator("response")
    @classmethod
    def _known_response(cls, name: str) -> str:
        return choices.require_known("response", name, choices.responses())


class LocalizationSection(Section):
    """When the vehicle stops and starts to use GNSS again.

    Attributes:
        hold_s: seconds that GNSS stays isolated after the last alarm.
        rejoin_s: seconds that fixes must agree with the estimate before they are used again.
        outage_s: seconds without a fix after which a vehicle counts as without GNSS.
        rollback_s: seconds before the alarm, at least, from which `rollback` and `ukf5_rollback` restart.
    """

    hold_s: float = Field(2.0, ge=0.0, le=600.0)
    rejoin_s: float = Field(1.0, ge=0.0, le=600.0)
    outage_s: float = Field(0.5, ge=0.0, le=600.0)
    # Where an attack grows slowly, the detectors' mean delay is 5 to 6.5 s (README.md).
    rollback_s: float = Field(6.0, ge=0.0, le=60.0)


class OutcomesSection(Section):
    """How results are summed up.

    Attributes:
        bootstrap: resamples (of vehicles) behind every interval.
        confidence: of the intervals.
    """

    bootstrap: int = Field(1000, ge=1, le=100_000)
    confidence: float = Field(0.95, gt=0.0, lt=1.0)
