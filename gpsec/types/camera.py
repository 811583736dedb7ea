"""How a lane camera errs about the lane that it shows."""

from typing import NamedTuple


class LaneMistakes(NamedTuple):
    """What a camera does where lanes change; without any it shows the lane under the rear axle.

    Attributes:
        hysteresis_m: it keeps to a lane until the rear axle is beyond the line by this much.
        late_s: and then for so long.
        wrong_per_h: mean number of times in an hour that it begins to show the lane beside its own, where there is one.
        wrong_s: how long each of them lasts.
        blind_m: it shows no lane while a line of it is nearer to the rear axle than this.
    """

    hysteresis_m: float = 0.1
    late_s: float = 0.0
    wrong_per_h: float = 0.0
    wrong_s: float = 1.0
    blind_m: float = 0.0


NO_MISTAKES = LaneMistakes()
