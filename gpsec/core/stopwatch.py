"""How long each stage of a run takes."""

from collections import defaultdict
from time import perf_counter

from gpsec.core.kernels import compile_seconds


class Stopwatch:
    """Adds up wall-clock seconds by stage.

    Attributes:
        stages_s: seconds of each stage so far, in the order in which stages were first entered.
        compile_s: seconds that went into compiling kernels; they count for no stage.
    """

    def __init__(self) -> None:
        self.stages_s: dict[str, float] = defaultdict(float)
        self.compile_s = 0.0
        self.start()

    def start(self) -> None:
        """Begin to count, whatever went on before."""
        self._since = perf_counter()
        self._compiled_s = compile_seconds()

    def lap(self, stage: str) -> None:
        """Count the time since `start` or the last lap for `stage`."""
        since, compiled_s = self._since, self._compiled_s
        self.start()
        compiled_s = self._compiled_s - compiled_s
        self.compile_s += compiled_s
        self.stages_s[stage] += self._since - since - compiled_s
