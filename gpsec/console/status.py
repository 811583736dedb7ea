"""What a command is doing, on a terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.text import Text


@contextmanager
def status(console: Console, prefix: str) -> Iterator[Callable[[str], None]]:
    """Give what shows on a terminal what is being done; elsewhere nothing is shown."""
    with console.status(Text(f"{prefix}…")) as shown:  # a str would be searched for rich's markup
        yield lambda stage: shown.update(Text(f"{prefix}{stage} …"))
