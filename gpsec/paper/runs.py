"""Where the finished runs are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gpsec.paper.studies import Group, Pinned


@dataclass(frozen=True)
class Runs:
    """Folders of the finished runs.

    Attributes:
        pinned: what was chosen on the training networks.
        groups: folders of the runs, by what they are for; see `Studies.groups`.
    """

    pinned: Pinned
    groups: Mapping[Group, Sequence[Path]]

    def of(self, *group: str) -> Sequence[Path]:
        """Return the folders of a group."""
        return self.groups[group]

    def one(self, *group: str) -> Path:
        """Return the folder of a group of one run."""
        (folder,) = self.groups[group]
        return folder
