"""What files need to outlast a crash: written through to the disk, and folders that change places in one step."""

import ctypes
import errno
import os
import shutil
from pathlib import Path

_AT_FDCWD = -100
_RENAME_EXCHANGE = 2
# File systems, such as some of a network, that cannot write a folder through.
_NO_SYNC = (errno.EINVAL, errno.ENOTSUP)


def sync(path: Path) -> None:
    """Write a file, or the names in a folder, through to the disk.

    Raises:
        OSError: the disk refuses.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise
    finally:
        os.close(descriptor)


def sync_tree(folder: Path) -> None:
    """Write the files of a folder and of those in it through to the disk, and then their names.

    Raises:
        OSError: the disk refuses.
    """
    for path in folder.iterdir():
        if path.is_dir() and not path.is_symlink():
            sync_tree(path)
        elif path.is_file() and not path.is_symlink():
            sync(path)
    sync(folder)


def exchange(one: Path, other: Path) -> None:
    """Let two paths of one file system change places in one step (`renameat2` of Linux).

    Raises:
        OSError: the system or the file system cannot, or one of them may not be moved.
    """
    try:
        renameat2 = ctypes.CDLL(None, use_errno=True).renameat2
    except (AttributeError, OSError, TypeError):  # another system, or a C library without it
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS)) from None
    paths = [os.fsencode(path) for path in (one, other)]
    if renameat2(_AT_FDCWD, paths[0], _AT_FDCWD, paths[1], ctypes.c_uint(_RENAME_EXCHANGE)) != 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code), str(one), None, str(other))


def link_tree(source: Path, target: Path) -> None:
    """Let `target` be the same files as `source`: a link to a file, a folder of links to a folder.

    Raises:
        OSError: the file system has no links, or somebody else owns a file.
    """
    if source.is_symlink() or not source.is_dir():
        os.link(source, target, follow_symlinks=False)
        return
    target.mkdir()
    for path in source.iterdir():
        link_tree(path, target / path.name)
    copy_attributes(source, target)


def copy_attributes(source: Path, target: Path) -> None:
    """Give `target` owner, mode, dates and further attributes of `source`.

    Raises:
        OSError: that is not for us to give.
    """
    wanted, found = source.stat(), target.stat()
    if (wanted.st_uid, wanted.st_gid) != (found.st_uid, found.st_gid):
        os.chown(target, wanted.st_uid, wanted.st_gid)
    shutil.copystat(source, target)
