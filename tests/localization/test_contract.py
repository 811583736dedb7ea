"""What holds for every registered response; the rules are in `gpsec.testing`."""

from typing import ClassVar

import numpy as np
import pytest

from gpsec.core.kernels import inline
from gpsec.localization.registry import RESPONSES
from gpsec.localization.responses import DeadReckoning, Response
from gpsec.testing import RESPONSE_CHECKS, BrokenContractError, check_response


def test_the_registry_knows_them_by_their_names() -> None:
    assert all(kind.name == name for name, kind in RESPONSES.items())


@pytest.mark.parametrize("check", RESPONSE_CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("response", list(RESPONSES))
def test_it_keeps_the_contract(response: str, check) -> None:
    check(RESPONSES[response])


class Silent(Response):
    name: ClassVar[str] = "silent"


Silent.__doc__ = None


class Lost(DeadReckoning):
    """Forgets where it is."""

    name: ClassVar[str] = "lost"

    def correct(self, rows, branches, tracks, vehicles, seen, world):
        """Move east, more and more."""
        branches.mean[rows, 0] += 5.0


@inline
def _by_company(mean, covariance, hint, room, world, profile, sight):
    covariance[0, 1] += 1.0
    return hint, 0


class Lopsided(Response):
    """Leaves a covariance that is none."""

    name: ClassVar[str] = "lopsided"
    correction = _by_company


class Company(DeadReckoning):
    """Corrects all by the first."""

    name: ClassVar[str] = "company"

    def correct(self, rows, branches, tracks, vehicles, seen, world):
        """Take the mean over the rows."""
        branches.mean[rows, 1] = np.mean(branches.mean[rows, 1])


@pytest.mark.parametrize(
    ("kind", "rule"),
    [
        (Silent, "a response has a docstring"),
        (Lost, "stays within 10 m"),
        (Lopsided, "a covariance is symmetric"),
        (Company, "in whatever company"),
    ],
)
def test_a_response_that_breaks_a_rule_is_told_which(kind, rule) -> None:
    with pytest.raises(BrokenContractError, match=rule):
        check_response(kind)
