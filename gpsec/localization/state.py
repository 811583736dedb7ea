"""State of every defence's filter: one for each branch.

A **branch** is a vehicle under a plan and a set of defences that have done the same so far. The same filter has seen
the same odometry and the same fixes, so that their states are equal to the last bit, and one filter serves them all. A
branch forks when an attack begins, and when its defences part: because one isolates GNSS and another does not, or with
another response, or because they take GNSS back at different times. So it costs little to try one more detector.

Defences with different filters are in different families, each with branches of its own.
"""

from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import kernel
from gpsec.core.tables import blank
from gpsec.types.answers import Answers

# In place of the number of a response: GNSS is trusted.
TRUSTS = -1


class Defences(NamedTuple):
    """The defences of a run, or k of them.

    Attributes:
        column: (k,) their numbers.
        detector: (k,) column of the alarm that each one listens to.
        response: (k,) number of its response, `TRUSTS` where it never isolates.
    """

    column: Ints
    detector: Ints
    response: Ints


class Cells(NamedTuple):
    """D defences of M track rows.

    Attributes:
        started: (M,) the first fix has come.
        fix_age_s: (M,) time since the last fix.
        lost: (M,) fixes have stopped coming.
        parts: (M,) in this step a defence gives GNSS up, or takes it back.
        alarm: (M, D) the defence's detector raises an alarm in this step.
        response: (M, D) number of the response with which GNSS is isolated, `TRUSTS` where it is not.
        quiet_s: (M, D) time in isolation without an alarm.
        branch: (M, D) row of the filter in the branches of the defence's family.
    """

    started: Flags = blank(False)
    fix_age_s: Floats = blank(0.0)
    lost: Flags = blank(False)
    parts: Flags = blank(False)
    alarm: Flags = blank(False, "defences")
    response: Ints = blank(TRUSTS, "defences")
    quiet_s: Floats = blank(0.0, "defences")
    branch: Ints = blank(-1, "defences")


class Branches(NamedTuple):
    """Filters of one family, with S states each, in F rows.

    Attributes:
        track: (F,) track row.
        response: (F,) number of the response with which GNSS is isolated, `TRUSTS` where it is not.
        entered: (F,) isolated since this very step.
        steps: (F,) steps since the first fix, -1 before.
        mean: (F, S) east and north of the rear axle (m), yaw (rad), and what else the filter estimates.
        covariance: (F, S, S).
        consistent_s: (F,) time in isolation in which fixes have agreed with the estimate.
        isolated_way_m: (F,) distance travelled in isolation.
        segment: (F,) map segment of the estimate at the last camera correction, -1 before.
        innovation: (F, 2) normalised innovations of the last GNSS update; their squares sum to its NIS.
        innovation_valid: (F,) there was a GNSS update in this step.
        repairs: (F,) times that a covariance had to be made positive definite again.
        past_mean, past_covariance, past_isolated: (F, B, …) ring of what the filter was at B times; the covariances by
            their lower triangles. B is 0 in families that do not go back. `gpsec.localization.history`.
    """

    track: Ints = blank(-1)
    response: Ints = blank(TRUSTS)
    entered: Flags = blank(False)
    steps: Ints = blank(-1)
    mean: Floats = blank(0.0, "states")
    covariance: Floats = blank(0.0, "states", "states")
    consistent_s: Floats = blank(0.0)
    isolated_way_m: Floats = blank(0.0)
    segment: Ints = blank(-1)
    innovation: Floats = blank(0.0, 2)
    innovation_valid: Flags = blank(False)
    repairs: Ints = blank(0)
    past_mean: Floats = blank(0.0, "snapshots", "states")
    past_covariance: Floats = blank(0.0, "snapshots", "triangle")
    past_isolated: Flags = blank(False, "snapshots")


@kernel
def report_estimates(rows: Ints, cells: Cells, branches: Branches, columns: Ints, answers: Answers) -> None:
    """Set estimates and flags of isolation of the track rows `rows` under the defences `columns` of a family."""
    for row in rows:
        for d in columns:
            branch = cells.branch[row, d]
            answers.estimate_m[row, d, 0] = branches.mean[branch, 0]
            answers.estimate_m[row, d, 1] = branches.mean[branch, 1]
            answers.isolated[row, d] = cells.response[row, d] >= 0
