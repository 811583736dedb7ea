from gpsec.paper.goals import _goal, _index, _responses
from gpsec.paper.tables import PaperRow


def test_a_goal_is_met_or_missed_by_its_bound():
    row = PaperRow("r", "f1", 0.9, 0.92, 0.91, 0.93, 5)
    assert _goal("F1", "at least", 0.9, row).met
    assert not _goal("F1", "at least", 0.95, row).met
    assert not _goal("F1", "at most", 0.9, row).met
    # The paper gives seconds to one decimal: 0.04 s is its 0 s.
    delays = [PaperRow("r", "delay_mean_s", 0.0, delay_s, None, None, 5) for delay_s in (0.04, 0.06)]
    assert [_goal("delay", "at most", 0.0, delay).met for delay in delays] == [True, False]
    undefined = PaperRow("r", "f1", 0.9, None, None, None, 0)
    assert not _goal("F1", "at least", 0.0, undefined).met
    assert _goal("F1", "at least", 0.9, row).found == "0.92 (0.91 to 0.93)"


def test_the_further_response_is_held_against_the_paper_s():
    rows = [
        PaperRow(f"{attack} / lstm_glr+{response}", "rmse_xy_m", None, value, None, None, 5)
        for attack, before, after in (("stealth", 0.4, 0.2), ("slow_stealth", 0.4, 0.3))
        for response, value in (("ukf", before), ("ukf5_rollback", after))
    ]
    assert [(goal.found, goal.met) for goal in _responses(_index(rows))] == [("0.50", True), ("0.75", False)]
