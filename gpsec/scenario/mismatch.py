"""The section `world`: by what the world differs from what filters and detectors take it to be."""

from math import hypot
from typing import Self

from pydantic import Field, model_validator

from gpsec.scenario.base import Section
from gpsec.types.camera import NO_MISTAKES

MAX_MAP_ERROR_M = 2.0


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
