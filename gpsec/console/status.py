"""What a command is doing, on a terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console


@contextmanager
def status(console: Console, prefix: str) -> Iterator[Callable[[str], None]]:
    """Give what shows on a terminal what is being done; elsewhere nothing is shown."""
    with console.status(f"{prefix}…") as shown:
        yield lambda stage: shown.update(f"{prefix}{stage} …")
