"""The `[world]` section: what is refused, and how it is said."""

from pathlib import Path

import pytest

from gpsec.core.errors import GpsecError
from gpsec.scenario import load_scenario
from gpsec.scenario.mismatch import WorldSection
from gpsec.scenario.overrides import parse_set


def load(repository: Path, *changes: str) -> WorldSection:
    return load_scenario(repository / "scenarios" / "slow_curve", [parse_set(f"world.{one}") for one in changes]).world


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (["gnss_whit_factor=2"], "unknown key 'gnss_whit_factor' in world: did you mean 'gnss_white_factor'?"),
        (["camera_factor=-1"], "world.camera_factor: expected at least 0, found -1"),
        (["map_road_m=2.5"], "world.map_road_m: expected at most 2, found 2.5"),
        (["map_shift_east_m=-2.5"], "world.map_shift_east_m: expected at least -2, found -2.5"),
        (
            ["map_shift_east_m=1.5", "map_shift_north_m=1.5"],
            "world: expected a map error of at most 2 m in all, found 2.12",
        ),
        (["multipath_share=0.1"], "world: expected multipath_share and multipath_m together, found 0.1 and 0"),
        (["multipath_m=0.5"], "world: expected multipath_share and multipath_m together, found 0 and 0.5"),
        (["gnss_common_share=1.1"], "world.gnss_common_share: expected at most 1, found 1.1"),
    ],
)
def test_a_mismatch_that_means_nothing_is_refused_in_one_sentence(
    repository: Path, changes: list[str], says: str
) -> None:
    with pytest.raises(GpsecError) as refused:
        load(repository, *changes)
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def test_what_is_stated_is_what_differs(repository: Path) -> None:
    assert load(repository).stated() == {}
    assert load(repository, "gnss_white_factor=1.5", "camera_factor=1").stated() == {"gnss_white_factor": 1.5}
