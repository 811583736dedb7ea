import numpy as np
import pytest

from gpsec.localization.rejoin import SwitchSettings
from gpsec.testing.contract import STEP_S
from gpsec.testing.rig import Rig, rig_figures

ISOLATING = ("ukf", "dead_reckoning")


def warm(rig: Rig, steps: int = 20) -> Rig:
    for _ in range(steps):
        rig.step()
    return rig


@pytest.fixture
def rig(straight) -> Rig:
    return warm(Rig(straight))


def test_an_alarm_isolates_at_once_and_no_fix_is_used_any_more(rig):
    rig.step(bias_m=(0.0, 50.0), alarm=True)
    for response in ISOLATING:
        assert rig.isolated(response)
        assert abs(rig.error_m(response)).max() < 1e-6
        assert not rig.filter(response).innovation_valid
    assert not rig.isolated("none")
    assert rig.error_m("none")[0, 1] > 1.0


def test_each_defence_listens_to_its_own_detector(straight):
    rig = warm(Rig(straight))
    rig.alarm[:] = False
    rig.alarm[0, rig.column("ukf")] = True
    rig.localize(rig.rows)
    assert [rig.isolated(name) for name in rig.responses] == [name == "ukf" for name in rig.responses]


def test_none_never_isolates(rig):
    for step in range(200):
        rig.step(alarm=step % 2 == 0, fix=step < 100, bias_m=(0.0, 5.0))
        assert not rig.isolated("none")


@pytest.mark.parametrize(("outage_s", "period_s", "expected_s"), [(0.5, 0.1, 0.5), (0.2, 1.0, 2.5), (3.0, 0.1, 3.0)])
def test_an_outage_isolates_once_fixes_are_overdue(straight, outage_s, period_s, expected_s):
    """After outage_s, or two and a half periods of the receiver where that is longer."""
    settings = SwitchSettings(outage_s=outage_s)
    rig = warm(Rig(straight, figures=rig_figures(gnss_period_s=period_s), settings=settings))
    steps = rig.steps_until(True, fix=False)
    assert steps == pytest.approx(expected_s / STEP_S + 1, abs=1)
    assert rig.isolated("dead_reckoning")
    assert not rig.isolated("none")


def test_a_receiver_that_is_slower_than_the_loop_is_not_an_outage(straight):
    rig = Rig(straight, figures=rig_figures(gnss_period_s=1.0))
    for step in range(300):
        rig.step(fix=step % 10 == 0)
        assert not any(rig.isolated(name) for name in rig.responses)


@pytest.mark.parametrize(("hold_s", "rejoin_s"), [(2.0, 1.0), (0.5, 3.0), (0.0, 0.0)])
def test_gnss_comes_back_after_the_longer_of_hold_and_agreement(straight, hold_s, rejoin_s):
    rig = warm(Rig(straight, settings=SwitchSettings(hold_s=hold_s, rejoin_s=rejoin_s)))
    for _ in range(10):
        rig.step(alarm=True, bias_m=(0.0, 5.0))
    expected = max(hold_s, rejoin_s, STEP_S) / STEP_S
    assert rig.steps_until(False) == round(expected)
    for response in ISOLATING:
        assert not rig.isolated(response)


def test_an_alarm_in_between_begins_the_hold_anew(rig):
    rig.step(alarm=True)
    for _ in range(15):
        rig.step()
    rig.step(alarm=True)
    assert rig.steps_until(False) == 20


@pytest.mark.parametrize("bias", [(0.0, 2.4), (30.0, 0.0), (-30.0, 0.0)])
def test_gnss_does_not_come_back_while_it_disagrees(rig, bias):
    """Across the lane the residual tells, along it the distance to the estimate."""
    rig.step(alarm=True, bias_m=bias)
    for _ in range(100):
        rig.step(bias_m=bias)
    for response in ISOLATING:
        assert rig.isolated(response)
    assert rig.steps_until(False) == 10


def test_gnss_does_not_come_back_unseen_by_the_camera(rig):
    rig.step(alarm=True, camera=False)
    for _ in range(60):
        rig.step(camera=False)
    assert rig.isolated("ukf")
    assert rig.steps_until(False) == 10


def test_one_fix_that_disagrees_begins_the_agreement_anew(straight):
    rig = warm(Rig(straight, settings=SwitchSettings(hold_s=0.0, rejoin_s=1.0)))
    rig.step(alarm=True)
    for _ in range(7):
        rig.step()
    rig.step(residual_m=3.0)
    assert rig.isolated("ukf")
    assert rig.steps_until(False) == 10


def test_after_an_outage_gnss_comes_back(rig):
    rig.steps_until(True, fix=False)
    for _ in range(50):
        rig.step(fix=False)
    assert rig.isolated("ukf")
    # Held for two seconds after fixes have come back, of which the last one must agree.
    assert rig.steps_until(False) == 20


def test_a_rejoined_filter_follows_gnss_again(straight):
    rig = warm(Rig(straight))
    rig.step(alarm=True)
    rig.steps_until(False)
    for _ in range(300):
        rig.step(bias_m=(0.0, 0.2))
    for response in ISOLATING:
        assert rig.error_m(response)[0, 1] == pytest.approx(0.2, abs=0.03)
        covariance = rig.filter(response).covariance
        assert abs(covariance - covariance.T).max() < 1e-12
        assert np.linalg.eigvalsh(covariance).min() > -1e-12


def test_the_odometers_scale_error_along_the_lane_is_forgiven_by_the_way_travelled(straight):
    """A kilometre at 1 % off: 10 m along the lane are no reason to keep GNSS out."""
    rig = warm(Rig(straight, speed_mps=25.0))
    rig.step(alarm=True)
    for _ in range(400):
        rig.step(alarm=True)
    rig.filter("ukf").mean[0] -= 10.0
    assert rig.steps_until(False) <= 21
    for _ in range(100):
        rig.step()
    assert abs(rig.error_m("ukf")[0, 0]) < 0.5


def test_nothing_happens_before_the_first_fix(straight):
    rig = Rig(straight)
    for _ in range(30):
        rig.step(fix=False, alarm=True)
    assert not rig.state.cells.started[0]
    assert not any(rig.isolated(name) for name in rig.responses)
    assert not rig.filter("ukf").mean.any()
    rig.step()
    assert rig.error_m("ukf")[0] == pytest.approx([0.0, 0.0])


def test_ukf_holds_the_lane_where_dead_reckoning_drifts_off(straight):
    """A gyro that turns 0.2°/s too fast, for 15 s at 10 m/s: 0.5 · 10 · 0.0035 · 15² = 3.9 m without the camera."""
    rig = warm(Rig(straight, figures=rig_figures(gyro_bias_rps=0.0035)))
    rig.seen.yaw_rate_rps[:] = 0.0035
    for _ in range(150):
        rig.step(alarm=True, bias_m=(0.0, 2.4))
    assert rig.error_m("dead_reckoning")[0, 1] == pytest.approx(3.9, abs=0.2)
    assert abs(rig.error_m("ukf")[0, 1]) < 0.3
    assert rig.error_m("none")[0, 1] == pytest.approx(2.4, abs=0.4)


@pytest.mark.parametrize(("yaw", "kept"), [(0.2, False), (-0.041, False), (0.039, True)])
def test_a_yaw_that_spoofed_fixes_have_turned_is_not_taken_into_isolation(rig, yaw, kept):
    """More than four standard deviations (of 0.01 rad) away from the heading sensor's, that one is taken."""
    own = rig.filter("dead_reckoning")
    own.mean[2] = yaw
    rig.seen.heading_rad[:] = 0.0
    rig.step(alarm=True)
    assert rig.filter("dead_reckoning").mean[2] == pytest.approx(yaw if kept else 0.0, abs=1e-12)
    assert (rig.filter("dead_reckoning").covariance[2, 2] < 0.01**2) == kept


def test_yaw_is_kept_where_fixes_are_only_lost(rig):
    own = rig.filter("dead_reckoning")
    own.mean[2] = 0.2
    rig.seen.heading_rad[:] = 0.0
    for _ in range(8):
        rig.step(fix=False)
    assert rig.isolated("dead_reckoning")
    assert rig.filter("dead_reckoning").mean[2] == pytest.approx(0.2, abs=1e-12)
