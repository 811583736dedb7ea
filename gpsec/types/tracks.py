"""Track rows: one belongs to a vehicle under an attack plan, and holds everything that depends on the spoofed fix.

Every vehicle has a track under plan 0 (no attack). Its track under another plan is forked from that one when its attack
begins, because until then the two are equal to the last bit.
"""

from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import blank

# A residual stands for a tenth of a second, whatever the step: detectors score at most so often, and learned so.
SAMPLE_S = 0.1


class Tracks(NamedTuple):
    """One vehicle under one attack plan; M track rows.

    Attributes:
        vehicle: (M,) vehicle row.
        plan: (M,) index of the plan; 0 is *no attack*.
        settled: (M,) the vehicle has been on the road long enough to be scored.
        attacked: (M,) the attack is active in this step (also where it denies the fix).
        start_step: (M,) step in which the attack began, -1 under plan 0.
        end_step: (M,) first step after the attack, -1 while it is not over and under plan 0.
        fix_m: (M, 2) GNSS position after the attack.
        fix_valid: (M,) there is one in this step.
        deviation_m: (M,) cross-track error of the undefended estimate after the last step, kept while attacked.
        lane: (M,) lane that the vehicle believes to be on, -1 where it has no idea yet.
        lane_known: (M,) no other lane is nearly as likely; otherwise nothing is compared with the map.
        unmatched: (M,) the camera sees a lane in this step, and no lane of the map that the vehicle may be on explains
            it, or the fix that it is compared with lies beside none of them.
        segment: (M,) map segment (of the vehicle's map) that the fix was matched to, -1 before.
        residual_m: (M,) camera offset minus map-matched offset of the paired fix; 0 where not valid.
        residual_valid: (M,) a residual was formed in this step.
        paired_m: (M, 2) the fix that it was formed of, carried on to now by odometer, gyro and heading.
    """

    vehicle: Ints = blank(-1)
    plan: Ints = blank(0)
    settled: Flags = blank(False)
    attacked: Flags = blank(False)
    start_step: Ints = blank(-1)
    end_step: Ints = blank(-1)
    fix_m: Floats = blank(0.0, 2)
    fix_valid: Flags = blank(False)
    deviation_m: Floats = blank(0.0)
    lane: Ints = blank(-1)
    lane_known: Flags = blank(False)
    unmatched: Flags = blank(False)
    segment: Ints = blank(-1)
    residual_m: Floats = blank(0.0)
    residual_valid: Flags = blank(False)
    paired_m: Floats = blank(0.0, 2)
