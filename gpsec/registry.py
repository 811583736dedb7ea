"""Names of the parts that can be chosen: attacks, detectors, responses, sensor profiles."""

from collections.abc import Iterator, Mapping
from typing import Generic, TypeVar

from gpsec.errors import GpsecError, nearest, shown

T = TypeVar("T")


class Registry(Mapping[str, T], Generic[T]):
    """A read-only mapping from name to part, whose unknown names are answered with the nearest known one."""

    def __init__(self, kind: str, parts: Mapping[str, T]) -> None:
        self.kind = kind
        self._parts = dict(parts)

    def __getitem__(self, name: str) -> T:
        """Return the part called `name`.

        Raises:
            GpsecError: there is none of that name.
        """
        try:
            return self._parts[name]
        except KeyError:
            raise GpsecError(f"unknown {self.kind} '{shown(name)}': {nearest(name, self._parts)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def __contains__(self, name: object) -> bool:
        return name in self._parts
