"""How long the window shows a step."""

from gpsec.traffic.sumo_gui import GuiWindow, Look, Pacer, window_arguments


class Clock:
    """A clock that goes on when somebody sleeps."""

    def __init__(self):
        self.now_s, self.slept_s = 100.0, []

    def __call__(self):
        return self.now_s

    def sleep(self, time_s):
        self.slept_s.append(round(time_s, 9))
        self.now_s += time_s


def test_a_step_takes_its_time_whatever_it_was_spent_on():
    clock = Clock()
    pacer = Pacer(0.05, clock, clock.sleep)
    pacer.wait()  # the first is shown at once
    clock.now_s += 0.01
    pacer.wait()
    clock.now_s += 0.2  # longer than a step: nothing to wait for, and nothing is made up for later
    pacer.wait()
    clock.now_s += 0.02
    pacer.wait()
    assert clock.slept_s == [0.04, 0.03]


def test_what_comes_before_an_attack_is_not_waited_for(monkeypatch, tmp_path):
    waited = []
    window = GuiWindow(50.0)
    monkeypatch.setattr(window._pacer, "wait", lambda: waited.append(1))
    for name in ("_move_bodies", "_move_ghost", "_colour", "_follow"):
        monkeypatch.setattr(window, name, lambda look: None)
    for followed in ("", "", "a", "a", "", "b"):
        window.show(Look(followed=followed))
    assert len(waited) == 4
    window_arguments(tmp_path)
    assert '<delay value="0"/>' in (tmp_path / "view.xml").read_text("utf-8")
