"""Defences share a filter until they part; then each has what it would have had alone."""

import numpy as np
import pytest

from gpsec.testing.rig import Rig

RESPONSES = ("none", "dead_reckoning", "ukf", "rollback", "ukf5")


def branches_of(rig: Rig, track: int = 0) -> dict[str, tuple[int, int]]:
    """The family and the row of the filter of each defence of a track."""
    families = [set(family.columns.tolist()) for family in rig.state.families]
    rows = rig.state.cells.branch[track].tolist()
    return {
        name: (next(number for number, family in enumerate(families) if d in family), rows[d])
        for d, name in enumerate(rig.responses)
    }


def steps(rig: Rig, count: int, **step: object) -> Rig:
    for _ in range(count):
        rig.step(**step)  # type: ignore[arg-type]
    return rig


def used(rig: Rig) -> int:
    """Rows of branches in use, over all families."""
    return sum(int((family.now.track >= 0).sum()) for family in rig.state.families)


def test_defences_of_one_filter_share_it_until_an_alarm(straight):
    rig = steps(Rig(straight, responses=RESPONSES, count=3), 20)
    branch = branches_of(rig)
    assert branch["none"] == branch["dead_reckoning"] == branch["ukf"]
    assert len(set(branch.values())) == 3
    assert used(rig) == 9
    rig.step(alarm=True)
    branch = branches_of(rig)
    assert len(set(branch.values())) == 5
    assert used(rig) == 15


def test_defences_that_heed_one_alarm_with_one_response_stay_together(straight):
    rig = Rig(straight, responses=("ukf", "ukf", "ukf", "none"))
    steps(rig, 20)
    rig.alarm[0] = True, True, False, True
    rig.localize(rig.rows)
    rows = rig.state.cells.branch[0].tolist()
    assert rows[0] == rows[1] != rows[2] == rows[3]
    assert rig.state.cells.response[0].tolist() == [0, 0, -1, -1]


@pytest.mark.parametrize("alarm", [(0, 40), (10, 25), (25, 10)])
def test_each_is_what_it_would_be_alone(straight, alarm):
    """Alarms that begin together, or apart, and GNSS that is taken back at different times."""
    rng = np.random.default_rng(4)
    noise = rng.normal(0.0, 0.05, (160, 4))

    def driven(defences: tuple[tuple[str, int], ...]) -> Rig:
        rig = Rig(straight, responses=tuple(response for response, _ in defences))
        for step in range(160):
            rig.vehicles.rear_m[:, 0] += 1.0
            rig.seen.speed_mps[:] = 10.0 + noise[step, 0]
            rig.tracks.fix_m[:] = rig.tracks.paired_m[:] = rig.vehicles.rear_m + noise[step, 1:3]
            rig.tracks.fix_valid[:] = rig.tracks.residual_valid[:] = rig.seen.camera_valid[:] = True
            rig.seen.lane_poly[:, 0] = noise[step, 3]
            rig.alarm[0] = [60 <= step < 60 + length for _, length in defences]
            rig.localize(rig.rows)
        return rig

    defences = (("none", 5), *((response, length) for response in ("ukf", "rollback", "ukf5") for length in alarm))
    together = driven(defences)
    for d, defence in enumerate(defences):
        branches, row = together.state.of(d)
        alone, own = driven((defence,)).state.of(0)
        for name, array, other in zip(branches._fields, branches, alone, strict=True):
            if name not in ("track", "response"):
                assert array[row[0]].tobytes() == other[own[0]].tobytes(), (defence, name)


def test_a_track_that_forks_goes_on_with_branches_of_its_own(straight):
    rig = steps(Rig(straight, responses=RESPONSES, count=3), 20)
    rig.alarm[:] = False
    rig.alarm[0, rig.column("ukf")] = True
    rig.localize(rig.rows)
    # Two plans may attack one vehicle from the same step on.
    rig.state.copy(np.array([0, 0], np.int32), np.array([1, 2], np.int32))
    one = branches_of(rig, 0)
    rows = set(one.values())
    for track in (1, 2):
        other = branches_of(rig, track)
        assert rows.isdisjoint(other.values())
        rows |= set(other.values())
        # The same defences share with the same others.
        assert [[one[a] == one[b] for b in one] for a in one] == [[other[a] == other[b] for b in other] for a in other]
    for name in rig.responses:
        filters = rig.filters(name)
        assert filters.mean[0].tobytes() == filters.mean[1].tobytes() == filters.mean[2].tobytes()
        assert filters.track.tolist() == [0, 1, 2]


def test_rows_of_a_track_that_begins_anew_are_used_again(straight):
    """However often vehicles come and go, there are no more branches than they need at once."""
    rig = Rig(straight, responses=RESPONSES, count=2)
    rows = []
    for _ in range(5):
        steps(rig, 5)
        rig.step(alarm=True)
        rows.append(max(row for track in range(2) for _, row in branches_of(rig, track).values()))
        rig.state.copy(np.array([0], np.int32), np.array([1], np.int32))
        assert used(rig) == 10
        rig.state.reset(rig.rows)
        assert used(rig) == 6
    assert len(set(rows)) == 1
