"""What the input files of a simulation say of attacks that vehicles carry."""

from dataclasses import dataclass, field
from glob import escape
from pathlib import Path

from gpsec.core.errors import shown
from gpsec.types.constants import PREFIX

ATTACK_KEY, PLAN_KEY, RADIUS_KEY = f"{PREFIX}attack", f"{PREFIX}plan", f"{PREFIX}radius_m"


@dataclass(frozen=True)
class CarriedAttack:
    """The ``gpsec.…`` parameters of something that carries an attack.

    Attributes:
        file: that it is in.
        element: its tag: ``vType``, ``vehicle``, ``trip`` or ``flow``.
        owner_id: its id.
        parameters: with their prefix.
    """

    file: Path
    element: str
    owner_id: str
    parameters: dict[str, str] = field(default_factory=dict)

    @property
    def where(self) -> str:
        """Its place, for error messages."""
        return f"{self.file}: {self.element} '{shown(self.owner_id)}'"

    @property
    def plan(self) -> str:
        """Name of its plan: as stated, otherwise its id."""
        return self.parameters.get(PLAN_KEY, "").strip() or self.owner_id

    @property
    def states_plan(self) -> bool:
        """Whether it states its plan, which several may share."""
        return bool(self.parameters.get(PLAN_KEY, "").strip())

    @property
    def transmits(self) -> bool:
        """Whether it is a spoofer that follows traffic; otherwise it is attacked itself."""
        return self.element == "vType" or bool(self.parameters.get(RADIUS_KEY, "").strip())

    @property
    def vehicles(self) -> str:
        """Pattern of the ids of its vehicles; a flow's are numbered behind a dot."""
        return escape(self.owner_id) + (".*" if self.element == "flow" else "")
