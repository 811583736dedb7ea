"""What a defence does while GNSS is isolated: each response is a filter, and how the camera corrects it."""

from typing import ClassVar

from gpsec.core.arrays import Ints
from gpsec.localization import consider_ukf, lane_ukf, paper_ukf
from gpsec.localization.family import Correction, Filter, correcting, no_correction, rewinding
from gpsec.localization.gated import GATED_EKF
from gpsec.localization.history import Recall, Recorded
from gpsec.localization.learning import LEARNING_EKF
from gpsec.localization.paper_ukf import PAPER_FILTER
from gpsec.localization.state import Branches
from gpsec.localization.world import World, make_room
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class Response:
    """Corrects the estimate of isolated branches, after it was propagated with odometer and gyro.

    Defences whose responses have the same filter share branches until they part.
    """

    name: ClassVar[str]
    # A response that never isolates leaves everything as it is, alarm or not.
    isolates: ClassVar[bool] = True
    # On an alarm the filter restarts from its past.
    rolls_back: ClassVar[bool] = False
    filter: ClassVar[Filter] = PAPER_FILTER
    # How the camera corrects the filter, compiled by `gpsec.core.kernels.inline`; None where it does not.
    correction: ClassVar[Correction | None] = None

    def correct(
        self, rows: Ints, branches: Branches, tracks: Tracks, vehicles: Vehicles, seen: Measurements, world: World
    ) -> None:
        """Correct the isolated branches `rows` with what is left when GNSS is not trusted."""
        correction = type(self).correction
        if correction is not None:
            room = make_room(self.filter.states)
            correcting(correction)(rows, branches, tracks, vehicles, seen, world, room)

    def rewind(
        self,
        rows: Ints,
        branches: Branches,
        tracks: Tracks,
        vehicles: Vehicles,
        recorded: Recorded,
        world: World,
        recall: Recall,
    ) -> None:
        """Replace the branches `rows`, which an alarm has just isolated, by what they were, brought up to now.

        It comes before `correct`: this step's motion is applied, its camera is not.
        """
        loop = rewinding(self.filter, type(self).correction or no_correction)
        loop(rows, branches, tracks, vehicles, recorded, world, recall, make_room(self.filter.states))


class NoResponse(Response):
    """GNSS is trusted whatever the detector says; the lower bound of every table."""

    name: ClassVar[str] = "none"
    isolates: ClassVar[bool] = False


class Gate(Response):
    """No alarm is heeded, but fixes that contradict odometer and gyro are refused: a baseline without a detector."""

    name: ClassVar[str] = "gate"
    isolates: ClassVar[bool] = False
    filter: ClassVar[Filter] = GATED_EKF


class DeadReckoning(Response):
    """Odometer and gyro alone: nothing corrects the propagated estimate."""

    name: ClassVar[str] = "dead_reckoning"


class CameraUkf(Response):
    """The paper's mitigation: the lane offset seen by the camera corrects the propagated position (Eqs 11-16)."""

    name: ClassVar[str] = "ukf"
    correction: ClassVar[Correction | None] = paper_ukf.correct_by_offset


class Rollback(CameraUkf):
    """On an alarm the filter restarts from before it; then it is the paper's UKF."""

    name: ClassVar[str] = "rollback"
    rolls_back: ClassVar[bool] = True


class ConsiderUkf(Response):
    """The paper's UKF, which considers what does not average away: camera, odometer scale, gyro bias and yaw."""

    name: ClassVar[str] = "consider_ukf"
    filter: ClassVar[Filter] = consider_ukf.CONSIDERING_EKF
    correction: ClassVar[Correction | None] = consider_ukf.correct_considering


class Ukf5(Response):
    """Odometer scale and gyro bias, learnt with GNSS, and lane offset and direction correct the estimate."""

    name: ClassVar[str] = "ukf5"
    filter: ClassVar[Filter] = LEARNING_EKF
    correction: ClassVar[Correction | None] = lane_ukf.correct_by_lane


class Ukf5Rollback(Ukf5):
    """On an alarm the filter restarts from before it; then it is `ukf5`."""

    name: ClassVar[str] = "ukf5_rollback"
    rolls_back: ClassVar[bool] = True
