"""The joint detector beyond what the monitor says."""

import numpy as np

from gpsec.detection.channels import silent_channels
from gpsec.detection.joint import UNMATCHED, Joint
from gpsec.testing.detector_bench import Bench
from tests.detection.test_chi_square import observe


def test_a_lane_that_nothing_matches_counts_as_evidence():
    told = silent_channels((1,))
    told.tested[:], told.joint[:] = True, 20.0
    bench = Bench(Joint(), 1)
    seen = observe(0.0)._replace(channels=told)
    matched = bench.ask(seen, np.array([41.0]))
    unmatched = bench.ask(seen._replace(unmatched=np.array([True])), np.array([41.0]))
    assert (matched.statistic[0], matched.alarm[0]) == (20.0, False)
    assert (unmatched.statistic[0], unmatched.alarm[0]) == (20.0 + UNMATCHED, True)
