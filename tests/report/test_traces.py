import numpy as np
import pandas as pd

from gpsec.report.stories import Story
from gpsec.report.traces import rows_of


def story_rows(step_s: float, every: int) -> pd.DataFrame:
    """The rows of 5 s in which a detector has a sample in one step of `every`, but for the last second."""
    steps = np.arange(round(5.0 / step_s))
    sampled = (steps % every == 0) & (steps * step_s < 4.0)
    log = pd.DataFrame(
        {
            "time_s": (steps + 1) * step_s,
            "vehicle_id": "a",
            "plan": "none",
            "camera_offset_m": np.where(sampled, 0.5, np.nan),
            "residual_m": np.where(sampled, 0.1, np.nan),
            "cusum_statistic": np.where(sampled, 2.0, np.nan),
            "fix_x_m": np.where(sampled, 1.0, np.nan),
        }
    )
    return rows_of(Story("lane", "carla", "a", "none", "", 0.0, 5.0, log[:0]), log)


def test_lines_go_on_between_the_samples_of_short_steps():
    rows = story_rows(0.01, 10)
    on, off = rows["time_s"] < 4.0, rows["time_s"] > 4.3
    for name, value in (("camera_offset_m", 0.5), ("residual_m", 0.1), ("cusum_statistic", 2.0)):
        assert (rows.loc[on, name] == value).all()
        assert rows.loc[off, name].isna().all()
    assert rows["fix_x_m"].isna().any()


def test_lines_have_gaps_where_nothing_is_known():
    assert story_rows(0.1, 3)["residual_m"].isna().sum() > 10
