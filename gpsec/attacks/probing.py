"""What an attacker who knows detectors asks before it sends a fix, and what it is told."""

from collections.abc import Callable
from typing import NamedTuple, Protocol, runtime_checkable

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.threads import Threads
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles


class Knowledge(NamedTuple):
    """What an attacker knows of detectors.

    Attributes:
        targets: operating points that it looks at, by their names in tables; none for all of the run.
        own_copy: it looks at a copy of its own, which knows nothing of what the vehicle's sensors said.
    """

    targets: tuple[str, ...]
    own_copy: bool


class Probed(NamedTuple):
    """What would be found in this step.

    Attributes:
        ratio: (m, C) statistic over threshold, the largest of the targets; above 1 there is an alarm. 0 where nothing
            is scored.
        scored: (m, C) some target would score.
    """

    ratio: Floats
    scored: Flags


# What detectors would say if the fixes of m victims were moved by (m, C, 2) metres.
Probe = Callable[[Floats], Probed]


class Question(NamedTuple):
    """What m track rows would have of each of C fixes in this step.

    Attributes:
        rows: (m,) track rows.
        moved_m: (m, C, 2) by how much the fixes are moved, from where they would be without an attack.
        columns: of the operating points that are asked.
        own_copy: the attacker asks a copy of its own, which is fed with sensors that have no errors.
    """

    rows: Ints
    moved_m: Floats
    columns: Ints
    own_copy: bool


@runtime_checkable
class Probes(Protocol):
    """An engine whose detectors can be asked what they would find."""

    def probe(
        self, number: int, asked: Question, tracks: Tracks, vehicles: Vehicles, seen: Measurements, threads: Threads
    ) -> Probed:
        """Return what would be found of other fixes in step `number`, which is taken next; change nothing."""
        ...


def asks_nobody(moved_m: Floats) -> Probed:
    """Refuse to answer.

    Raises:
        TypeError: always, a mistake in the attack.
    """
    raise TypeError("an attack that asks `probe` says in `known` of which detectors")
