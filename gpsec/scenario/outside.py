"""Parts that come from outside gpsec: which are loaded with a scenario, and from where."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from gpsec.core.errors import GpsecError, shown
from gpsec.scenario.paths import UNUSABLE, expand, reason


class Outside(NamedTuple):
    """Parts and permissions that the user gives, beside the parts that a scenario file names.

    Attributes:
        parts: references; files are relative to the current folder.
        allow_code: load the code that a scenario file names, too.
    """

    parts: tuple[str, ...] = ()
    allow_code: bool = False


NOTHING = Outside()


def load_parts(references: Sequence[str], folder: Path, *, allow_code: bool) -> tuple[str, ...]:
    """Load parts; return their references with whole paths.

    Args:
        references: as a user writes them.
        folder: that relative paths start from.
        allow_code: the user has chosen them; else those that are code have to be loaded already.

    Raises:
        ValueError: one is code that may not be loaded, or cannot be loaded.
    """
    from gpsec.scenario import parts  # late: it knows all parts that there are

    try:
        whole = tuple(parts.relocate(text, lambda place: str(expand(place, folder))) for text in references)
        for text, reference in zip(references, whole, strict=True):
            if parts.is_code(reference) and not (allow_code or parts.in_use(reference)):
                raise GpsecError(
                    f"'{shown(text)}' is code, and a scenario may come from somebody else; --allow-code runs it"
                )
        parts.use(whole)
    except GpsecError as error:
        raise ValueError(str(error)) from None
    except UNUSABLE as error:
        raise ValueError(f"cannot be used as a path: {reason(error)}") from None
    return whole
