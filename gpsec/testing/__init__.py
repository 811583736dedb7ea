"""The contracts that every part of gpsec keeps, for parts of others.

In a test, call ``check_attack(MyAttack)`` or ``check_detector(lambda profiles: MyDetector(), threshold)``. A check that
fails raises `BrokenContractError`, an AssertionError that says what the part has to do.
"""

from gpsec.testing.attacks import ATTACK_CHECKS, check_attack
from gpsec.testing.contract import BrokenContractError
from gpsec.testing.detectors import DETECTOR_CHECKS, check_detector

__all__ = ["ATTACK_CHECKS", "DETECTOR_CHECKS", "BrokenContractError", "check_attack", "check_detector"]
