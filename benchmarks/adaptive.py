"""The adaptive attacker: what it costs to try 45 fixes, against as many further residuals and statistics."""

from collections.abc import Collection, Iterator

import pandas as pd

from benchmarks.bench import Bench
from benchmarks.city import ROOT
from benchmarks.figures import Figure, Round, Sample
from gpsec.attacks.adaptive import TRIED

SECONDS, QUICK_SECONDS = 60.0, 12.0
SCENARIO = ROOT / "scenarios" / "town"
TARGET = "joint"
# Everybody is under attack all the time, and nothing that is not needed is computed.
SETTINGS = (
    'detection.detectors=["joint"]',
    'defences=[{detector="joint", response="none"}]',
    "fleet.settle_s=5",
)
WHEN = "share=1.0, start_after_s=[0.0,0.0], duration_s=[600.0,600.0]"
# What is done for a track in a step, and again for each fix that is tried.
STAGES = ("association", "matching", "monitor", f"detector {TARGET}")

ADAPTIVE = Figure(
    "adaptive_ratio", "trying 45 fixes of a victim ÷ 45 times what one costs a track: lane, residual, statistic", 1.0
)
ADAPTIVE_US = Figure("adaptive_us", "the adaptive attacker of joint, µs a victim-step")
FIGURES = (ADAPTIVE, ADAPTIVE_US)


def measure(bench: Bench, wanted: Collection[str]) -> Iterator[Round]:
    """Yield rounds of the town under an attacker that knows the detector, and under one that does not."""
    seconds = QUICK_SECONDS if bench.quick else SECONDS
    common = ["--duration", str(seconds), "--seed", "1", "--jobs", "1"]
    common += [part for setting in SETTINGS for part in ("--set", setting)]
    for _ in range(bench.runs):
        plans = {
            "fixed": f'{{attack="drift", {WHEN}}}',
            "adaptive": f'{{attack="adaptive", target="{TARGET}", {WHEN}}}',
        }
        stages, victims, steps = {}, {}, {}
        for name, plan in plans.items():
            _, manifest = bench.gpsec(name, SCENARIO, *common, "--set", f"plans=[{plan}]")
            events = pd.read_csv(bench.work / "out" / "events.csv")
            events = events[(events["attack"].isin(("drift", "adaptive"))) & (events["defence"] == "never+none")]
            stages[name], victims[name] = manifest["stages_s"], events["attack_seconds"].sum() / manifest["step_s"]
            steps[name] = manifest["track_steps"]
        tried_s = stages["adaptive"]["attacks"] - stages["fixed"]["attacks"]
        one_us = 1e6 * sum(stages["fixed"][stage] for stage in STAGES) / steps["fixed"]
        victim_us = 1e6 * tried_s / victims["adaptive"]
        of = {"victim_steps": victims["adaptive"], "one_us": one_us}
        yield {ADAPTIVE.key: Sample(victim_us / (TRIED * one_us), of), ADAPTIVE_US.key: Sample(victim_us, of)}
