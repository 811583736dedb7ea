"""What is measured, and what is wished for."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Figure:
    """A number that `make bench` gives.

    Attributes:
        key: in ``bench.json``.
        what: one line on how it is got.
        goal: None where it is only stated.
        at_least: the goal is a lower bound, not an upper one.

    """

    key: str
    what: str
    goal: float | None = None
    at_least: bool = False

    @property
    def wish(self) -> str:
        """The goal in words, empty where there is none."""
        return "" if self.goal is None else f"{'≥' if self.at_least else '≤'} {self.goal:g}"

    def met(self, value: float) -> bool | None:
        """Return whether `value` is as wished, None where nothing is."""
        if self.goal is None:
            return None
        return value >= self.goal if self.at_least else value <= self.goal


@dataclass(frozen=True)
class Sample:
    """A figure in one round.

    Attributes:
        value: of the figure.
        of: what it was made from.

    """

    value: float
    of: dict[str, float] = field(default_factory=dict)


# What a round gives: samples by the key of their figure.
Round = dict[str, Sample]
