"""Names of the parts that can be chosen: attacks, detectors, responses, sensor profiles.

A registry has the parts of gpsec, those of installed packages (entry points), and those that a user names (`add`).
"""

from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from gpsec.core.errors import GpsecError, nearest, shown

T = TypeVar("T")
# Name and part where the object is one of this kind, None where it is something else.
Take = Callable[[Any], tuple[str, T] | None]


class Registry(Mapping[str, T], Generic[T]):
    """A mapping from name to part, whose unknown names are answered with the nearest known one.

    Attributes:
        kind: of the parts, in sentences.
        group: of the entry points by which an installed package adds parts.
        own: names of gpsec's own parts, which defaults are made of: they do not change with what is installed.
    """

    def __init__(self, kind: str, group: str, parts: Mapping[str, T], take: Take[T]) -> None:
        self.kind = kind
        self.group = group
        self._take = take
        self._parts = dict(parts)
        self.own = tuple(parts)
        # Name -> module of a part that is not gpsec's own.
        self._modules: dict[str, str] = {}
        self._installed = False

    def __getitem__(self, name: str) -> T:
        """Return the part called `name`.

        Raises:
            GpsecError: there is none of that name, or an installed package has one that cannot be loaded.
        """
        if name not in self._parts:
            self._load_installed()
        try:
            return self._parts[name]
        except KeyError:
            raise GpsecError(f"unknown {self.kind} '{shown(name)}': {nearest(name, self._parts)}") from None

    def __iter__(self) -> Iterator[str]:
        self._load_installed()
        return iter(self._parts)

    def __len__(self) -> int:
        self._load_installed()
        return len(self._parts)

    def __contains__(self, name: object) -> bool:
        if name not in self._parts:
            self._load_installed()
        return name in self._parts

    def add(self, made: Any, source: str) -> str | None:
        """Add a part from outside gpsec; return its name, None where `made` is no part of this kind.

        Args:
            made: a class, or a sensor profile.
            source: where it comes from, for sentences.

        Raises:
            GpsecError: the name is that of another part.
        """
        found = self._take(made)
        if found is None:
            return None
        name, part = found
        module = getattr(made, "__module__", "") if isinstance(made, type) else ""
        if name in self._parts and (self._modules.get(name) != module or not module):
            if self._parts[name] == part:
                return name
            raise GpsecError(f"{source}: the name '{shown(name)}' is that of another {self.kind}; give it its own")
        self._parts[name] = part
        self._modules[name] = module
        return name

    def module_of(self, name: str) -> str:
        """Return the module of a part from outside gpsec, empty where it is gpsec's own or a file of figures."""
        return self._modules.get(name, "")

    def _load_installed(self) -> None:
        if self._installed:
            return
        self._installed = True
        for entry in sorted(entry_points(group=self.group), key=lambda entry: entry.name):
            source = f"{entry.dist.name if entry.dist else 'an installed package'}: {entry.value}"
            if self.add(_load(entry, source), source) is None:
                raise GpsecError(
                    f"{source}: is no {self.kind} with a name, as an entry point in '{self.group}' has to be"
                )


def _load(entry: EntryPoint, source: str) -> Any:
    try:
        return entry.load()
    except Exception as error:
        raise GpsecError(f"{source}: cannot be imported: {type(error).__name__}: {error}") from error


def subclass_named(base: type[Any]) -> Take[Any]:
    """Return a `Take` of subclasses of `base` that have a name."""

    def take(made: Any) -> tuple[str, Any] | None:
        name = getattr(made, "name", None)
        if not isinstance(made, type) or not issubclass(made, base) or not isinstance(name, str):
            return None
        return name, made

    return take
