"""The version of gpsec, which files that it writes have in them."""

__version__ = "0.1.0"
