from multiprocessing import Pipe
from signal import SIGABRT, SIGBUS, SIGKILL, SIGRTMIN, SIGSEGV

import pytest

from gpsec.core.pipes import PeerGoneError, receive, send
from gpsec.core.processes import ended_early


@pytest.mark.parametrize("unread", [False, True])
def test_an_end_that_is_gone(unread: bool) -> None:
    ours, theirs = Pipe()
    theirs.send("last word")
    if unread:
        ours.send("never read")
    theirs.close()
    with pytest.raises(PeerGoneError):
        send(ours, "anybody there?")
    assert receive(ours) == "last word"
    with pytest.raises(PeerGoneError):
        receive(ours)
    ours.close()
    with pytest.raises(PeerGoneError):
        send(ours, "after all is closed")


def test_other_errors_of_the_system_are_not_taken_for_it() -> None:
    ours, _theirs = Pipe()

    class Full:
        def __reduce__(self) -> tuple[object, ...]:
            raise ValueError("not of the pipe")

    with pytest.raises(ValueError, match="not of the pipe"):
        send(ours, Full())


@pytest.mark.parametrize(
    ("exit_code", "said"),
    [
        (None, "exit status None"),
        (3, "exit status 3"),
        (-SIGKILL, "SIGKILL: most likely the system ran out of memory"),
        (-SIGSEGV, "SIGSEGV: a crash of SUMO itself"),
        (-SIGABRT, "SIGABRT: it gave up, for want of memory or by a fault of its own"),
        (-SIGBUS, "SIGBUS: most likely a disk or shared memory is full"),
        (-(SIGRTMIN + 1), f"signal {SIGRTMIN + 1}"),
    ],
)
def test_how_a_process_ended(exit_code: int | None, said: str) -> None:
    assert ended_early("it", exit_code, "a crash of SUMO itself") == f"it ended early ({said})"
