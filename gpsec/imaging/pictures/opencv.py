"""OpenCV, which only this package imports, and only where it is needed: it is an optional extra."""

from functools import cache
from types import ModuleType

from gpsec.core.errors import GpsecError


@cache
def opencv() -> ModuleType:
    """Return OpenCV, on one thread: what is worked on in parallel are pictures, not parts of one.

    Raises:
        GpsecError: it is not installed.
    """
    try:
        import cv2
    except ImportError as error:
        raise GpsecError(
            f"pictures need the extra 'image' (pip install 'gpsec[image]'), found no OpenCV: {error}"
        ) from None
    cv2.setNumThreads(1)
    return cv2
