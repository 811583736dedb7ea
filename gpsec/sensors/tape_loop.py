"""A tape as a loop without seams: where one piece ends and the next begins, the one fades into the other."""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats
from gpsec.types.tapes import Tape

FADE_S = {"camera": 0.5, "gnss": 20.0}
"""How long a fade takes, by the kind of a tape; of a piece that is shorter than four of them, a quarter."""


class TapeLoop(NamedTuple):
    """A tape that may be played round and round; L samples.

    Attributes:
        errors: (L, K) measured less true, 0 where missing.
        missing: (L,).
        sigma_m: (L,) what the sensor stated.
    """

    errors: Floats
    missing: Flags
    sigma_m: Floats


def make_loop(tape: Tape) -> TapeLoop:
    """Return the loop of a tape; it is shorter than that by the fades.

    In a fade the end of a piece has the weight cos θ and the beginning of the next one sin θ, with θ from 0 to 90°.
    They are independent, so that the variance stays. Where one of them is missing, the other one is taken while it
    weighs more; otherwise the sample is missing.
    """
    pieces = np.split(np.arange(len(tape.missing)), tape.piece[1:])
    fades = [_fade(tape, one, other) for one, other in zip(pieces, [*pieces[1:], pieces[0]], strict=True)]
    parts: list[TapeLoop] = []
    for number, piece in enumerate(pieces):
        before, after = fades[number - 1], fades[number]
        parts.append(_taken(tape, piece[before : len(piece) - after]))
        if after:
            following = pieces[(number + 1) % len(pieces)]
            parts.append(_blend(_taken(tape, piece[len(piece) - after :]), _taken(tape, following[:after])))
    return TapeLoop(*(np.ascontiguousarray(np.concatenate(arrays)) for arrays in zip(*parts, strict=True)))


def _fade(tape: Tape, piece: np.ndarray, following: np.ndarray) -> int:
    """Return how many samples of a piece fade into the following one."""
    longest = round(FADE_S[tape.kind] * tape.rate_hz)
    return min(longest, len(piece) // 4, len(following) // 4)


def _taken(tape: Tape, samples: np.ndarray) -> TapeLoop:
    return TapeLoop(tape.errors[samples], tape.missing[samples], tape.sigma_m[samples])


def _blend(one: TapeLoop, other: TapeLoop) -> TapeLoop:
    count = len(one.missing)
    angle = 0.5 * np.pi * (np.arange(count) + 0.5) / count
    weight, following = np.cos(angle), np.sin(angle)
    first = weight > following
    both = ~one.missing & ~other.missing
    # Alone, the heavier one has its whole size.
    alone = np.where(first, ~one.missing, ~other.missing) & ~both
    weight = np.where(both, weight, np.where(alone & first, 1.0, 0.0))
    following = np.where(both, following, np.where(alone & ~first, 1.0, 0.0))
    return TapeLoop(
        weight[:, None] * one.errors + following[:, None] * other.errors,
        ~(both | alone),
        np.sqrt((weight * one.sigma_m) ** 2 + (following * other.sigma_m) ** 2),
    )
