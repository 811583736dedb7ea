"""The contracts that every part of gpsec keeps, for parts of others.

In a test, call ``check_attack(MyAttack)``, ``check_detector(lambda profiles: MyDetector(), threshold)`` or
``check_profile(MY_CAR)``. A check that fails raises `BrokenContractError`, an AssertionError that says what the part
has to do.
"""

from gpsec.testing.attacks import ATTACK_CHECKS, check_attack
from gpsec.testing.contract import BrokenContractError
from gpsec.testing.detectors import DETECTOR_CHECKS, check_detector
from gpsec.testing.profiles import PROFILE_CHECKS, check_profile

__all__ = [
    "ATTACK_CHECKS",
    "DETECTOR_CHECKS",
    "PROFILE_CHECKS",
    "BrokenContractError",
    "check_attack",
    "check_detector",
    "check_profile",
]
