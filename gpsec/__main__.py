"""`python -m gpsec`."""

import sys

from gpsec.cli import main

if __name__ == "__main__":
    sys.exit(main())
