"""Every batched stage against its reference, step by step, on real trajectories under attack."""

import pytest

from gpsec.types.constants import ASSOCIATIONS

from .drive import Drive, drive_through
from .side_by_side import SideBySide

TOLERANCE = 1e-9
# The batched network is float32, with an exponential good to 3e-7; its reference is float64. Over a recurrence of
# hundreds of steps the difference stays of the order of float32 rounding, and squaring the error doubles it.
FLOAT32_TOLERANCE = 1e-5


NETWORKS = ("town", "sharp_turns")
ALL = [(network, kind) for network in NETWORKS for kind in ASSOCIATIONS]
# Each of them takes half a minute of processor time; the others are slow tests.
SAMPLE = [("town", "tracked"), ("town", "nearest"), ("sharp_turns", "tracked"), ("sharp_turns", "oracle")]
ONE_NETWORK = pytest.mark.parametrize(
    "drive", ["town", pytest.param("sharp_turns", marks=pytest.mark.slow)], indirect=True
)


@pytest.mark.parametrize(
    ("drive", "kind"),
    [pytest.param(*one, marks=() if one in SAMPLE else pytest.mark.slow) for one in ALL],
    indirect=["drive"],
)
def test_both_engines_agree_after_every_step(drive: Drive, kind: str):
    method = SideBySide(drive.associated(kind))
    drive_through(drive.associated(kind), 3, method)
    found = method.found
    assert max(found.worst.pop(name) for name in ("lstm", "lstm_glr", "lstm_cusum")) < FLOAT32_TOLERANCE
    assert {quantity: worst for quantity, worst in found.worst.items() if not worst < TOLERANCE} == {}
    assert +found.disagreements == {}
    # The comparison was of something: every detector was silent and in alarm, every filter ran and was left again.
    assert found.seen["track step"] > 3000
    assert 0.5 < found.seen["residual"] / found.seen["track step"] < 1.0
    watching = ("innovation", "joint", "separation")
    for detector in ("chi_square", "cusum", "isolation_forest", "lstm", "lstm_glr", "lstm_cusum", *watching, "told"):
        assert 100 < found.seen[f"{detector} alarm"] < 0.8 * found.seen["track step"]
    assert found.seen["never alarm"] == 0
    assert min(found.seen["monitor alarm"], found.seen["monitor blind"], found.seen["monitor has learnt"]) > 50
    assert found.seen["fork"] == 15
    assert found.seen["gate has learnt"] > 50
    assert min(found.seen["isolation begins"], found.seen["isolation ends"]) > 30
    assert found.seen["camera correction"] > 1000
    assert found.seen["lane correction"] > 1000
    assert min(found.seen["rollback"], found.seen["lane rollback"]) > 5
    assert found.seen["in a junction"] > 20
    assert kind != "nearest" or found.seen["on another lane"] > 100
    assert found.seen["repair"] == 0


def test_both_engines_agree_at_a_short_step(short_steps: Drive):
    """Residuals are of samples of different steps, and GNSS is taken back by fixes of earlier ones."""
    method = SideBySide(short_steps)
    drive_through(short_steps, 3, method)
    found = method.found
    assert max(found.worst.pop(name) for name in ("lstm", "lstm_glr", "lstm_cusum")) < FLOAT32_TOLERANCE
    assert {quantity: worst for quantity, worst in found.worst.items() if not worst < TOLERANCE} == {}
    assert +found.disagreements == {}
    # Ten or five residuals a second in forty steps.
    assert 0.1 < found.seen["residual"] / found.seen["track step"] < 0.25
    assert found.seen["late residual"] > 0.5 * found.seen["residual"]
    assert min(found.seen["isolation begins"], found.seen["isolation ends"]) > 10


# Statistics of the LSTM are compared by themselves, for they are float32.
KNOWING = ["chi_square", "cusum", "isolation_forest", "innovation", "joint", "separation"]


@ONE_NETWORK
def test_both_engines_tell_an_attacker_the_same(drive: Drive):
    method = SideBySide(drive, copies=True)
    attacks = [
        {"attack": "adaptive", "name": "white", "target": KNOWING, "junctions": "move"},
        {"attack": "adaptive", "name": "grey", "target": ["joint"], "knowledge": "grey"},
    ]
    drive_through(drive, 1, method, attacks)
    found = method.found
    for name in ("lstm", "lstm_glr", "lstm_cusum"):
        assert found.worst.pop(name) < FLOAT32_TOLERANCE
    assert {quantity: worst for quantity, worst in found.worst.items() if not worst < TOLERANCE} == {}
    assert +found.disagreements == {}
    for whose in ("probe", "own copy"):
        assert min(found.seen[f"{whose} passes"], found.seen[f"{whose} alarm"]) > 50


@ONE_NETWORK
def test_both_engines_tell_an_attacker_the_same_of_the_lstm(drive: Drive):
    method = SideBySide(drive)
    drive_through(drive, 1, method, [{"attack": "adaptive", "target": ["lstm_glr"]}])
    assert method.found.worst["probe"] < FLOAT32_TOLERANCE
    assert method.found.disagreements["probe scored"] == 0
    assert method.found.seen["probe passes"] > 50
