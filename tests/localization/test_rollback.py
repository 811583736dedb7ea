import numpy as np
import pytest

from gpsec.localization import lane_ukf
from gpsec.localization.history import SNAPSHOTS, Recall
from gpsec.localization.rejoin import SwitchSettings
from gpsec.testing.rig import Rig

RESPONSES = ("none", "ukf", "rollback", "ukf5", "ukf5_rollback")
BACK = ("rollback", "ukf5_rollback")


def spoilt(straight, seconds: float, **settings: float) -> Rig:
    """12 s of honest fixes, then some in which they creep ahead by 0.3 m/s."""
    rig = Rig(straight, responses=RESPONSES, settings=SwitchSettings(**settings))
    for _ in range(120):
        rig.step()
    for step in range(round(10 * seconds)):
        rig.step(bias_m=(0.03 * (step + 1), 0.0))
    return rig


def test_on_an_alarm_what_the_attack_has_done_is_undone(straight):
    rig = spoilt(straight, 5.0)
    before = rig.error_m("rollback").copy()
    rig.step(bias_m=(1.5, 0.0), alarm=True)
    assert before[0, 0] > 0.5
    assert rig.error_m("ukf")[0, 0] > 0.5
    assert rig.error_m("ukf5")[0, 0] > 0.3
    for response in BACK:
        assert abs(rig.error_m(response)).max() < 1e-6
        assert rig.isolated(response)


def test_it_goes_back_as_far_as_it_is_told(straight):
    """Six seconds of creeping, one and a half (and up to half a second more) undone: error of the EKF before that."""
    rig = spoilt(straight, 6.0)
    earlier = spoilt(straight, 4.0)
    short = spoilt(straight, 6.0, rollback_s=1.6)
    for one in (rig, short):
        one.step(bias_m=(1.8, 0.0), alarm=True)
    assert abs(rig.error_m("rollback")[0, 0]) < 1e-6
    assert short.error_m("rollback")[0, 0] == pytest.approx(earlier.error_m("ukf")[0, 0], abs=0.06)


def test_fixes_that_were_lost_have_spoilt_nothing(straight):
    """An outage is no alarm: nobody goes back, so that what GNSS has said until then is kept."""
    rig = spoilt(straight, 5.0)
    rig.steps_until(True, "rollback", fix=False)
    for plain, back in (("ukf", "rollback"), ("ukf5", "ukf5_rollback")):
        assert rig.error_m(back).tobytes() == rig.error_m(plain).tobytes()
        assert rig.error_m(back)[0, 0] > 0.3


def test_a_second_alarm_does_not_bring_back_what_the_first_has_undone(straight):
    """The filters that were kept during the attack are replaced by those of the way back."""
    rig = spoilt(straight, 6.0, hold_s=0.0, rejoin_s=0.0)
    rig.step(bias_m=(1.8, 0.0), alarm=True)
    rig.steps_until(False, "rollback")
    for _ in range(30):
        rig.step()
    rig.step(alarm=True)
    # Back to the middle of the attack.
    for response in BACK:
        assert abs(rig.error_m(response)).max() < 1e-3


def test_a_young_track_goes_back_to_its_first_fix(straight):
    rig = Rig(straight, responses=("rollback",))
    for _ in range(10):
        rig.step(bias_m=(0.0, 0.4), camera=False)
    rig.step(bias_m=(9.0, 0.4), alarm=True, camera=False)
    assert rig.error_m("rollback")[0] == pytest.approx([0.0, 0.4], abs=1e-9)
    assert rig.filter("rollback").isolated_way_m == pytest.approx(10 * rig.speed_mps * 0.1)


def test_stored_camera_corrects_on_the_way(straight):
    """What the camera has seen since corrects the estimate before the alarm's own step does."""
    rig = Rig(straight, responses=("rollback",))
    for step in range(40):
        rig.step(bias_m=(0.0, 0.4), camera=step > 10)
    rig.step(bias_m=(0.0, 0.4), alarm=True, camera=False)
    assert abs(rig.error_m("rollback")[0, 1]) < 0.1


def test_it_comes_again_along_the_way_that_was_driven(straight):
    """30 cm left of the lane's centre and ever faster: each stored step counts at its own time, on its own side."""
    rig = Rig(straight, responses=BACK)
    rig.vehicles.rear_m[:, 1] = 0.3
    rig.seen.lane_poly[:, 0] = -0.3
    for step in range(116):  # by no round number of steps: one too early would then be one too late
        rig.speed_mps = 5.0 + 0.2 * step
        rig.seen.speed_mps[:] = rig.speed_mps
        rig.step(bias_m=(50.0, 0.0) if step == 115 else (0.0, 0.0), alarm=step == 115)
    for response in BACK:
        assert abs(rig.error_m(response)).max() < 1e-3


def test_a_yaw_that_the_heading_sensor_contradicts_is_not_brought_back(straight):
    """The filter that is restored began with a heading that was 0.2 rad off, twenty times its standard deviation."""
    rig = Rig(straight, responses=BACK)
    rig.seen.heading_rad[:] = 0.2
    rig.step(camera=False)
    rig.seen.heading_rad[:] = 0.0
    for step in range(10):
        rig.step(camera=False, alarm=step == 9)
    for response in BACK:
        assert rig.filter(response).mean[2] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("response", BACK)
def test_the_camera_of_the_alarms_own_step_corrects_once(straight, response):
    """With it, the filter is what it is without it after one correction across a straight lane, a linear one."""
    without, seen = (Rig(straight, responses=(response,)) for _ in range(2))
    for rig in (without, seen):
        for _ in range(40):
            rig.step()
    without.step(alarm=True, camera=False)
    seen.step(alarm=True, camera=True)
    before, after = (rig.filter(response).covariance for rig in (without, seen))
    states = [1, 2, 3, 4, 5, 6] if response == "ukf5_rollback" else [1]
    P = before[np.ix_(states, states)]
    if response == "ukf5_rollback":
        # Offset: y and the camera's two errors; slope of the lane: less yaw.
        H = np.array([[1.0, 0.0, 1.0, 1.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0, 0.0, 0.0]])
        white, slope = lane_ukf.camera_noise(without.world.noise, 0, 0.08)
        both = -without.figures.camera_slope_correlation * white * slope
        R = np.array([[white**2, both], [both, slope**2]])
    else:
        H, R = np.ones((1, 1)), np.array([[0.08**2]])
    expected = P - P @ H.T @ np.linalg.inv(H @ P @ H.T + R) @ H @ P
    np.testing.assert_allclose(after[np.ix_(states, states)], expected, rtol=2e-3, atol=1e-9)


@pytest.mark.parametrize(("rollback_s", "step_s"), [(6.0, 0.1), (6.0, 0.04), (0.0, 0.1), (0.25, 0.1), (60.0, 0.2)])
def test_one_kept_filter_is_always_old_enough_and_still_there(rollback_s, step_s):
    recall = Recall.over(rollback_s, step_s)
    assert recall.reach * step_s >= rollback_s - 1e-9
    for last in range(recall.reach, recall.reach + 3 * recall.steps):
        number = (last - recall.reach) // recall.interval
        age = last - number * recall.interval
        assert recall.reach <= age < recall.reach + recall.interval
        assert last // recall.interval - number < SNAPSHOTS
        assert age + 1 <= recall.steps


def test_nothing_is_kept_where_nobody_goes_back(straight):
    assert Rig(straight, responses=("ukf", "none", "rollback")).filter("ukf").past_mean.size == 0
    assert Rig(straight, responses=("rollback",)).filter("rollback").past_mean.shape == (SNAPSHOTS, 5)
