"""Where the time of a run goes."""

from collections import defaultdict
from time import perf_counter


class Stopwatch:
    """Adds up wall-clock seconds by stage.

    Attributes:
        stages_s: seconds of each stage so far, in the order in which stages were first entered.

    """

    def __init__(self) -> None:
        self.stages_s: dict[str, float] = defaultdict(float)
        self._since = perf_counter()

    def start(self) -> None:
        """Begin to count, whatever went on before."""
        self._since = perf_counter()

    def lap(self, stage: str) -> None:
        """Count the time since `start` or the last lap for `stage`."""
        now = perf_counter()
        self.stages_s[stage] += now - self._since
        self._since = now
