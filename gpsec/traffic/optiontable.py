"""The options that the installed SUMO knows, asked from SUMO itself."""

import re
import subprocess
from dataclasses import dataclass
from functools import cache

from gpsec.core.errors import GpsecError
from gpsec.sumo.home import environment, program

_TOPIC = re.compile(r"    <(\w+)>$")
_OPTION = re.compile(r'        <([\w.\-]+) value="([^"]*)"(?: synonymes="([^"]*)")?.* type="([A-Z\[\]]+)"')


@dataclass(frozen=True)
class SumoOption:
    """One option of sumo.

    Attributes:
        name: the canonical one, without dashes in front.
        topic: element of a configuration that it is written in, such as ``output``.
        default: value that it has where none is given.
        is_file: its value is a path, or paths separated by commas.
    """

    name: str
    topic: str
    default: str
    is_file: bool


@cache
def sumo_options_by_name() -> dict[str, SumoOption]:
    """Return sumo's options by every name they go by: canonical, alias, one letter.

    Raises:
        GpsecError: sumo cannot be run.
    """
    sumo = program("sumo")
    command = [str(sumo), "--save-template", "stdout", "--save-commented"]
    try:
        template = subprocess.run(command, capture_output=True, text=True, check=True, env=environment()).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise GpsecError(f"{sumo}: expected SUMO's list of options, found: {error}") from None
    return parse_template(template)


def parse_template(template: str) -> dict[str, SumoOption]:
    """Return the options in what ``sumo --save-template stdout --save-commented`` prints, by every name.

    The template is read by the line: it is no well-formed XML, because the comments in it are not escaped.
    """
    options: dict[str, SumoOption] = {}
    topic = ""
    for line in template.splitlines():
        if start := _TOPIC.match(line):
            topic = start[1]
        elif found := _OPTION.match(line):
            name, default, synonyms, kind = found.groups()
            option = SumoOption(name, topic, default, kind == "FILE")
            for known_as in (name, *(synonyms or "").split()):
                options[known_as] = option
    return options
