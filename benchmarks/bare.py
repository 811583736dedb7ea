"""Steps SUMO and does nothing else: ``python -m benchmarks.bare STEPS SUMO-OPTION ...``.

Prints the seconds of the loop. A module of its own, so that nothing but libsumo is loaded.
"""

import sys
from time import perf_counter

import libsumo


def main() -> None:
    """Run, as the command line says."""
    libsumo.start(["sumo", *sys.argv[2:]])
    began = perf_counter()
    for _ in range(int(sys.argv[1])):
        libsumo.simulationStep()
    print(perf_counter() - began)
    libsumo.close()


if __name__ == "__main__":
    main()
