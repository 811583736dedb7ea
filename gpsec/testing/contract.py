"""What all contracts share."""

STEP_S = 0.1
"""Length of the steps in which they look at a part."""


class BrokenContractError(AssertionError):
    """A part does not do what every part of its kind has to do."""


def require(kept: object, rule: str) -> None:
    """Refuse a part that does not keep a rule.

    Raises:
        BrokenContractError: `kept` is false.
    """
    if not kept:
        raise BrokenContractError(rule)
