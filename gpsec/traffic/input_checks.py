"""Looks at the input files of a configuration before SUMO reads them."""

from pathlib import Path
from xml.etree import ElementTree

from gpsec.core.errors import GpsecError, shown
from gpsec.traffic.config import SumoConfig, is_file, missing_file
from gpsec.traffic.inputs import UNREADABLE, open_input
from gpsec.traffic.network import refuse_addresses

# Inputs in XML beside net, routes and additional files.
_OTHER_INPUTS = ("load-state", "weight-files")
# Roots of files that have no vehicles in them.
_NO_ROUTES = {
    "net": "a net",
    "configuration": "a SUMO configuration",
    "sumoConfiguration": "a SUMO configuration",
}


def checked_input_files(config: SumoConfig) -> dict[str, list[Path]]:
    """Return the files under ``net-file``, ``route-files`` and ``additional-files``, absolute.

    Raises:
        GpsecError: one is missing, is of another kind than its option takes, or names a host of the network.
    """
    files = {key: config.paths(key) for key in ("net-file", "route-files", "additional-files")}
    for key, paths in files.items():
        for path in paths:
            if not is_file(path):
                raise missing_file(config, key, path)
            if "," in str(path):
                raise GpsecError(f"{config.path}: SUMO cannot read '{shown(path)}' because of the comma in its path")
    if not files["net-file"]:
        raise GpsecError(f"{config.path}: expected the key 'net-file', found no net")
    _check_net(config, files["net-file"][0])
    _check_routes(config, files["route-files"])
    refuse_addresses([path for key in (*files, *_OTHER_INPUTS) for path in config.paths(key)])
    return files


def _check_net(config: SumoConfig, path: Path) -> None:
    """Refuse what is not a net before SUMO reads it: libsumo crashes on a net without a version."""
    try:
        with open_input(path) as stream:
            _, root = next(ElementTree.iterparse(stream, events=("start",)))
    except (*UNREADABLE, StopIteration) as error:
        raise GpsecError(f"{config.path}: net-file '{shown(path)}' is not readable as XML: {error}") from None
    if root.tag != "net" or not root.get("version"):
        found = f"<{shown(root.tag)}>" if root.tag != "net" else "<net> without a version"
        raise GpsecError(f"{config.path}: net-file '{shown(path)}': expected <net version=…>, found {found}")


def _check_routes(config: SumoConfig, paths: list[Path]) -> None:
    """Refuse route files that are files of another kind: SUMO only warns of them, and then nobody departs."""
    for path in paths:
        try:
            with open_input(path) as stream:
                _, root = next(ElementTree.iterparse(stream, events=("start",)))
        except (*UNREADABLE, StopIteration):
            continue  # SUMO's session says what is wrong with it
        if root.tag in _NO_ROUTES:
            raise GpsecError(
                f"{config.path}: route-files names '{shown(path)}': expected routes, found {_NO_ROUTES[root.tag]} "
                f"(<{root.tag}>)"
            )
