"""The folder of a sweep: its list of simulations, and where everything else lies."""

import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence
from gpsec.core.version import __version__
from gpsec.outcomes.tables import whole
from gpsec.pipeline.fingerprint import environment_digest
from gpsec.sweeps.points import ListedTask
from gpsec.sweeps.store import Store

LIST, TABLES_FOLDER, LOGS, FAILURES = "sweep.jsonl", "tables", "logs", "failed"
_FORMAT = 1


@dataclass(frozen=True)
class SweepFolder:
    """A sweep on the disk. Its list is read a line at a time: ten thousand scenarios are 40 MB of JSON.

    Attributes:
        path: of the folder.
        store: of the results.
        parameters: keys that vary, in the order of the plan, and what they are: `number`, `flag` or `text`.
        environment: digest of code and libraries that it was listed with.
        version: of gpsec that it was listed with.
        labels: by fingerprint, in the order of the plan.
        allow_code: the code that its scenarios name may be run; the folder may be somebody else's.
    """

    path: Path
    store: Store
    parameters: dict[str, str]
    environment: str
    version: str
    labels: dict[str, str]
    _places: dict[str, list[int]]
    allow_code: bool = False

    def tasks(self, fingerprint: str) -> list[ListedTask]:
        """Return what a simulation is to each entry that it is part of.

        Raises:
            GpsecError: the list has been changed meanwhile.
        """
        found = []
        with (self.path / LIST).open("rb") as file:
            for place in self._places[fingerprint]:
                file.seek(place)
                try:
                    found.append(ListedTask.model_validate_json(file.readline()))
                except ValidationError:
                    raise GpsecError(f"{self.path / LIST}: expected the list of a sweep, found other data") from None
        return found

    def log(self, fingerprint: str) -> Path:
        """Return the log of a simulation."""
        return self.path / LOGS / f"{fingerprint[:16]}.log"

    def check_environment(self) -> None:
        """Check that simulations come out here as they would where they were listed.

        Raises:
            GpsecError: code or libraries are of another version.
        """
        if self.environment != environment_digest():
            raise GpsecError(
                f"{self.path}: expected {_said(self.version, self.environment)}, with which it was listed, found "
                f"{_said(__version__, environment_digest())}: go on with that version, or choose another --out"
            )


def _said(version: str, digest: str) -> str:
    return f"gpsec {version} with code and libraries {digest[:12]}"


def write_list(
    path: Path,
    tasks: Iterable[ListedTask],
    parameters: dict[str, str],
    store: Path | None,
    *,
    allow_code: bool = False,
) -> SweepFolder:
    """Write the list of a sweep into its folder, which need not exist; return it. What was listed before is replaced.

    `store` is another folder for the results, which may have those of other sweeps.

    Raises:
        GpsecError: the folder holds something else, or a sweep of another version; or the disk refuses.
    """
    if (path / LIST).exists():
        read_folder(path).check_environment()
    elif path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise GpsecError(f"{path}: expected a new or empty folder, or that of a sweep; choose another --out")
    Store(path / "store" if store is None else store).check()
    head = {
        "gpsec_sweep": _FORMAT,
        "version": __version__,
        "environment": environment_digest(),
        "parameters": parameters,
        "store": "store" if store is None else str(store.resolve()),
    }
    with in_a_sentence(f"{path}: cannot be written"), _gone_where_it_fails(path), whole(path / LIST) as partial:
        with partial.open("w", encoding="utf-8") as file:
            file.write(json.dumps(head) + "\n")
            for task in tasks:
                file.write(task.model_dump_json() + "\n")
        for name in (LOGS, FAILURES, TABLES_FOLDER):
            (path / name).mkdir(exist_ok=True)
    found = read_folder(path, allow_code=allow_code)
    found.store.make()
    return found


@contextmanager
def _gone_where_it_fails(path: Path) -> Iterator[None]:
    """Leave no empty folder where there was none, if the block fails: scenarios are read while the list is written."""
    is_new = not path.exists()
    try:
        yield
    except BaseException:
        if is_new:
            with suppress(OSError):
                path.rmdir()
        raise


def read_folder(path: Path, *, allow_code: bool = False) -> SweepFolder:
    """Return the sweep in a folder.

    Raises:
        GpsecError: there is none, or its list is of another form.
    """
    file = path / LIST
    if not path.is_dir() or not file.is_file():
        raise GpsecError(f"{path}: expected the folder of a sweep, found {_instead(path)}")
    labels: dict[str, str] = {}
    places: dict[str, list[int]] = {}
    try:
        with file.open("rb") as lines:
            head: dict[str, Any] = json.loads(lines.readline())
            if head.get("gpsec_sweep") != _FORMAT:
                raise GpsecError(
                    f"{file}: expected a list of form {_FORMAT}, found {head.get('gpsec_sweep')}: it is of another "
                    "version of gpsec"
                )
            place = lines.tell()
            for line in lines:
                # The rest of the line is read when the simulation is.
                one = json.loads(line)
                labels.setdefault(one["fingerprint"], one["label"])
                places.setdefault(one["fingerprint"], []).append(place)
                place += len(line)
            store = Store(path / head["store"])
            parameters = dict(head["parameters"])
            stated = head["environment"], head["version"]
    except OSError as error:
        raise GpsecError(f"{file}: cannot be read: {error.strerror}") from None
    except (ValueError, LookupError, TypeError, AttributeError):
        raise GpsecError(f"{file}: expected the list of a sweep, found other data") from None
    return SweepFolder(path, store, parameters, *stated, labels, places, allow_code)


def _instead(path: Path) -> str:
    if not path.exists():
        return "nothing"
    return f"no {LIST} in it" if path.is_dir() else "a file"
