"""Keeps SUMO from the network: it connects to a ``host:port`` wherever a file to write may be named."""

import re
from collections.abc import Iterable
from pathlib import Path

from gpsec.core.errors import GpsecError, shown
from gpsec.sumo.home import expand_variables
from gpsec.traffic.input_files import fault, input_files, references

_PORT = re.compile(r"\s*[+-]?\d+\s*")


def refuse_addresses(files: Iterable[Path]) -> None:
    """Refuse network addresses in place of files, in SUMO's input `files` and in all that they include.

    Raises:
        GpsecError: there is one, or a file cannot be searched for it.
    """
    for path in input_files(files):
        for named in references(path):
            if is_address(named.value):
                raise GpsecError(
                    f"{path}: {shown(named.element)}: {shown(named.attribute)}: expected a file, found the network "
                    f"address '{shown(named.value)}'"
                )
        if words := fault(path):
            raise GpsecError(f"{path}: expected XML in UTF-8, UTF-16 or Latin, found: {shown(words)}")


def is_address(name: str) -> bool:
    """Return whether SUMO takes the name of a file for a ``host:port``; one letter before the colon is a drive."""
    host, _, port = expand_variables(name).partition(":")
    return len(host) > 1 and _PORT.fullmatch(port) is not None
