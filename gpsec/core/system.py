"""What the system refuses, in one sentence: paths are the user's to mend, a full disk and limits the machine's."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager

from gpsec.core.errors import GpsecError, MachineError

_OF_PATHS = frozenset(
    (
        *(errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENOTEMPTY, errno.ELOOP, errno.ENAMETOOLONG),
        *(errno.EACCES, errno.EPERM, errno.EROFS),
    )
)
_LIMITS = {errno.EMFILE: "ulimit -n", errno.EFBIG: "ulimit -f", errno.ENOMEM: "ulimit -v", errno.EAGAIN: "ulimit -u"}


def refusal(error: OSError, said: str) -> GpsecError:
    """Return the error for what the system said; `said` names the file or folder, and what cannot be done with it."""
    kind = GpsecError if error.errno in _OF_PATHS else MachineError
    why = error.strerror or str(error) or type(error).__name__
    limit = _LIMITS.get(error.errno or 0)
    return kind(f"{said}: {why} ({limit})" if limit else f"{said}: {why}")


@contextmanager
def in_a_sentence(said: str) -> Iterator[None]:
    """Turn what the system refuses in this block into one sentence; a reader who has had enough is left alone.

    Raises:
        GpsecError: see `refusal`.
    """
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise refusal(error, said) from None
