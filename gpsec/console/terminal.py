"""Tables, bars and notes on the terminal; no id, no value and no sentence of SUMO in them steers it."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from gpsec.core.errors import printable


class Terminal(Console):
    """A console on which every text is shown as it is: escaped, and without rich's markup being heeded in it."""

    def render_str(self, text: str, **form: Any) -> Text:
        """Return a text with its form; it is measured as it is shown."""
        return super().render_str(_escaped(text), **form | {"markup": False})

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Yield the parts of what is printed."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield Segment(_escaped(segment.text), segment.style)

    def note(self, line: str) -> None:
        """Print one line as it is, however long."""
        self.print(line, markup=False, highlight=False, soft_wrap=True)


def messages() -> Terminal:
    """Return the console for progress, notes and errors."""
    return Terminal(stderr=True, emoji=False)


def tables(width: int) -> Terminal:
    """Return the console for tables, which have `width` in a file or a pipe."""
    return Terminal(emoji=False) if sys.stdout.isatty() else Terminal(width=width, emoji=False)


@contextmanager
def status(console: Console, prefix: str) -> Iterator[Callable[[str], None]]:
    """Give what shows on a terminal what is being done; elsewhere nothing is shown."""
    with console.status(Text(f"{prefix}…")) as shown:  # a str would be searched for rich's markup
        yield lambda stage: shown.update(Text(f"{prefix}{stage} …"))


def _escaped(text: str) -> str:
    return "\n".join(map(printable, text.split("\n")))
