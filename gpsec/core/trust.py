"""Tells whether anybody but the user and root can change a file or a folder."""

import grp
import os
import pwd
import stat
from pathlib import Path

from gpsec.core.errors import GpsecError

_ACL = "system.posix_acl_access"


def refuse_shared(folder: Path, where: str, variable: str) -> None:
    """Refuse a folder in which somebody else can change things, by itself or by one of its parents, as ssh does.

    In a parent where everybody may write but only rename what is theirs, such as ``/tmp``, one's own folder is safe.
    `where` and `variable` are for the sentence: what named the folder, and which variable names another one.

    Raises:
        GpsecError: somebody else than the user and root can.
    """
    for place in (folder, *folder.parents):
        info = place.lstat()
        shared = info.st_mode & stat.S_ISVTX and place != folder
        if not _is_trusted(info.st_uid):
            found = f"{place} belongs to {_user(info.st_uid)}"
        elif not shared and _others_write(place, info):
            found = f"others can write {place} (mode {stat.S_IMODE(info.st_mode):o})"
        else:
            continue
        raise GpsecError(
            f"{where}: expected a folder that only you and root can change, found that {found}; "
            f"take it from them (chown, chmod go-w) or name another one in {variable}"
        )


def is_ours(place: Path | int) -> bool:
    """Return whether nobody else can change a folder or an (open) file; a link is not asked where it leads."""
    info = os.fstat(place) if isinstance(place, int) else place.lstat()
    return not stat.S_ISLNK(info.st_mode) and _is_trusted(info.st_uid) and not _others_write(place, info)


def _is_trusted(user: int) -> bool:
    # Where root's number is not known, in a namespace of users, root is who owns the root folder.
    return user in (os.geteuid(), 0, Path("/").stat().st_uid)


def _others_write(place: Path | int, info: os.stat_result) -> bool:
    """Return whether its mode lets others write, where the user's own group, without anybody else, is none.

    With an access-control list, the bits of the group are those of everybody who is on it.
    """
    if info.st_mode & stat.S_IWOTH:
        return True
    return bool(info.st_mode & stat.S_IWGRP) and (not _is_private(info.st_gid) or _ACL in os.listxattr(place))


def _is_private(group: int) -> bool:
    try:
        user, named = pwd.getpwuid(os.geteuid()), grp.getgrgid(group)
    except KeyError:
        return False
    return group == user.pw_gid and named.gr_name == user.pw_name and set(named.gr_mem) <= {user.pw_name}


def _user(number: int) -> str:
    try:
        return f"'{pwd.getpwuid(number).pw_name}'"
    except KeyError:
        return f"user {number}"
