"""Reads arrays from .npz files that anybody may have made: no pickle, and one kind of error whatever is wrong."""

import zipfile
import zlib
from io import BytesIO
from lzma import LZMAError
from struct import error as StructError  # noqa: N812
from tokenize import TokenError
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

# What a zip archive, its compression or the header of an array raises where a byte of it is wrong. MemoryError: a
# header may ask for more than any machine has.
_DAMAGED = (
    OSError,
    EOFError,
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    ArithmeticError,
    RuntimeError,
    MemoryError,
    SyntaxError,
    TokenError,
    StructError,
    LZMAError,
    zlib.error,
    zipfile.BadZipFile,
)
# A recording of a day of a city has a few gigabytes; an archive may claim more than there are disks.
MAX_BYTES = 1 << 36


class DamagedError(ValueError):
    """A file holds no arrays that can be read; its text says why in a few words."""


def read_npz(stream: BinaryIO) -> dict[str, NDArray[Any]]:
    """Return the arrays in an .npz file by name.

    Raises:
        DamagedError: it is no archive, or one of its members is no plain array.
    """
    try:
        with zipfile.ZipFile(stream) as archive:
            members = archive.infolist()
            if sum(member.file_size for member in members) > MAX_BYTES:
                raise DamagedError("it claims to hold more than can be read")
            # zipfile compares the checksum of each member as it is read.
            return {member.filename.removesuffix(".npy"): _array(archive.read(member)) for member in members}
    except _DAMAGED as error:
        said = " ".join(str(error).split())[:100]
        raise DamagedError(said or type(error).__name__) from None


def is_text(array: NDArray[Any]) -> bool:
    """Return whether all letters of an array of texts are in Unicode, and no halves of letters."""
    if array.dtype.kind != "U" or array.size == 0 or array.dtype.itemsize == 0:
        return True
    letters = np.ascontiguousarray(array).reshape(-1).view(np.uint32)
    return bool((letters <= 0x10FFFF).all() and not ((letters >= 0xD800) & (letters < 0xE000)).any())


def _array(content: bytes) -> NDArray[Any]:
    stream = BytesIO(content)
    array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    if stream.read(1):
        raise DamagedError("an array is followed by something else")
    return array
