"""The contracts that every part of gpsec keeps, for parts of others.

In a test, call ``check_attack(MyAttack)``, ``check_detector(lambda profiles: MyDetector(), threshold)``,
``check_response(MyResponse)``, ``check_profile(MY_CAR)``, ``check_reaction(MyReaction)`` or
``check_dynamics(MyDynamics)``. A check that fails raises `BrokenContractError`, an
AssertionError that says what the part has to do.
"""

from gpsec.testing.attacks import ATTACK_CHECKS, check_attack
from gpsec.testing.contract import BrokenContractError
from gpsec.testing.detectors import DETECTOR_CHECKS, check_detector
from gpsec.testing.profiles import PROFILE_CHECKS, check_profile
from gpsec.testing.responses import RESPONSE_CHECKS, check_response
from gpsec.testing.steering import STEERING_CHECKS, check_dynamics, check_reaction

__all__ = [
    "ATTACK_CHECKS",
    "DETECTOR_CHECKS",
    "PROFILE_CHECKS",
    "RESPONSE_CHECKS",
    "STEERING_CHECKS",
    "BrokenContractError",
    "check_attack",
    "check_detector",
    "check_dynamics",
    "check_profile",
    "check_reaction",
    "check_response",
]
