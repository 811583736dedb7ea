"""What one simulation of a sweep stands for: which entry and parameters its rows are of."""

from typing import Any

from pydantic import Field

from gpsec.scenario.base import Section


class Cell(Section):
    """A plan of a simulation, which stands for a plan of the scenario with other parameters.

    Attributes:
        plan: that it stands for.
        parameters: that it has, by their keys in the grid; without the share.
        share_key: key of its share in the grid, empty where that does not vary.
        shares: of the vehicles that are attacked, to which its rows are filtered.
    """

    plan: str
    parameters: dict[str, Any]
    share_key: str = ""
    shares: tuple[float, ...] = Field((), strict=False)


class Point(Section):
    """What a simulation is to an entry of the plan.

    Attributes:
        entry: name of it.
        scenario: name, without seed and world.
        seed: of the run.
        parameters: of the simulation as a whole, by their keys in the grid.
        cells: by the name of a plan in the simulation; one that is not here is the scenario's own.
        equipped: shares of the fleet, to which its rows are filtered; empty for all of it.
    """

    entry: str
    scenario: str
    seed: int
    parameters: dict[str, Any] = Field({})
    cells: dict[str, Cell] = Field({})
    equipped: tuple[float, ...] = Field((), strict=False)

    @property
    def group(self) -> str:
        """What it has in common with the runs of other seeds, as a text."""
        return self.model_copy(update={"seed": 0}).model_dump_json()


class ListedTask(Section):
    """One simulation of a sweep, for one entry.

    Attributes:
        fingerprint: of its results, which is their place in the store; that of another entry may be the same.
        label: for people.
        point: what it stands for.
        told: the scenario as JSON.
    """

    fingerprint: str
    label: str
    point: Point
    told: str
