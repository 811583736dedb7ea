"""Tapes that sensors play while detectors learn and are calibrated: one run after the other takes the next one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from gpsec.core.errors import GpsecError
from gpsec.sensors.profiles import SensorProfile
from gpsec.sensors.shipped_tapes import load_tape
from gpsec.sensors.tapes import Tapes, check_tape
from gpsec.types.tapes import Tape


@dataclass(frozen=True)
class TrainingTapes:
    """Tapes in the order in which runs take them.

    Attributes:
        camera, gnss: by what they are of, with their names.
        digests: name -> digest, of all.
    """

    camera: tuple[tuple[str, Tape], ...]
    gnss: tuple[tuple[str, Tape], ...]
    digests: dict[str, str]

    @classmethod
    def of(cls, names: Sequence[str]) -> Self:
        """Return tapes by their names, or by files ending in ``.npz``.

        Raises:
            GpsecError: one is not there, or is damaged.
        """
        found = {name: load_tape(name) for name in names}
        kinds = {
            kind: tuple((name, tape) for name, (tape, _) in found.items() if tape.kind == kind)
            for kind in ("camera", "gnss")
        }
        return cls(kinds["camera"], kinds["gnss"], {name: digest for name, (_, digest) in found.items()})

    def of_run(self, number: int, profile: SensorProfile, step_s: float) -> Tapes:
        """Return the tapes of a run for a profile; runs are numbered from 0.

        Raises:
            GpsecError: one has fewer samples a second than the profile's sensor.
        """
        taken: dict[str, Tape] = {}
        for kind, tapes in (("gnss", self.gnss), ("camera", self.camera)):
            if tapes:
                name, taken[kind] = tapes[number % len(tapes)]
                check_tape(taken[kind], name, kind, [profile], step_s)
        return Tapes(taken.get("gnss"), taken.get("camera"))

    def check_same(self, digests: dict[str, str], model: str) -> None:
        """Refuse tapes that are not those with which a model was trained, name -> digest.

        Raises:
            GpsecError: they differ.
        """
        if digests != self.digests:
            was, given = (", ".join(sorted(one)) or "none" for one in (digests, self.digests))
            raise GpsecError(f"--tape: expected the tapes that {model} was trained with ({was}), found {given}")
