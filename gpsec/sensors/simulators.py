"""The paper's first two set-ups as its simulators give them: what no simulator has by itself is not there.

A simulator's wheel speed has noise where it is asked for, and no scale error; its camera sits where it says. Its
errors are Gaussian, and it loses markings by the clock. The profiles `dsd` and `carla` have the odometer, the mounting
and the camera's errors of a real car, of which these are copies but for that.
"""

from collections.abc import Mapping

from gpsec.sensors import sources as s
from gpsec.sensors.profiles import SensorProfile

# Figure -> value and source, by channel.
Changes = Mapping[str, Mapping[str, tuple[float, str]]]
_NOT_GAUSSIAN = ("tail_share", "tail_factor", "slope_correlation")

_NO_SCALE = {"scale_ratio": (0.0, s.SIMULATED_SPEED)}
_NO_MOUNT = {"mount_m": (0.0, s.SIMULATED_MOUNT)}


def as_simulated(profile: SensorProfile, title: str, changes: Changes) -> SensorProfile:
    """Return a copy of a profile under the name ``<profile>_sim``, with some of its figures replaced."""
    made = profile.model_dump()
    made["camera"] |= dict.fromkeys(_NOT_GAUSSIAN) | {"visibility": "clock"}
    made["camera"]["sources"] = {k: v for k, v in made["camera"]["sources"].items() if k not in _NOT_GAUSSIAN}
    for channel, figures in changes.items():
        for figure, (value, source) in figures.items():
            made[channel][figure] = value
            made[channel]["sources"] = {**made[channel]["sources"], figure: source}
    return SensorProfile.model_validate(made | {"name": f"{profile.name}_sim", "title": title})


def simulated(dsd: SensorProfile, carla: SensorProfile) -> tuple[SensorProfile, SensorProfile]:
    """Return `dsd_sim` and `carla_sim`."""
    lane_noise = {
        "white_m": (0.05, s.SIMULATED_LANE),
        "bias_m": (0.0, s.SIMULATED_LANE),
        "latency_s": (0.0, s.SIMULATED_CLOCK),
    }
    slow = {"bias_tau_s": (10.0, s.PAINT_TAU)}
    return (
        as_simulated(
            dsd,
            "dsd in its simulator: no scale error, no mounting offset, white lane noise",
            {"odometer": _NO_SCALE, "camera": slow | lane_noise | _NO_MOUNT},
        ),
        as_simulated(
            carla,
            "carla in its simulator: no scale error, no mounting offset",
            {"odometer": _NO_SCALE, "camera": slow | _NO_MOUNT},
        ),
    )
