"""The contracts that every part of gpsec keeps, for parts of others: in a test, ``check_attack(MyAttack)``.

A check that fails raises `BrokenContractError`, an AssertionError that says what the part has to do.
"""

from gpsec.testing.attacks import ATTACK_CHECKS, check_attack
from gpsec.testing.contract import BrokenContractError

__all__ = ["ATTACK_CHECKS", "BrokenContractError", "check_attack"]
