"""The networks, by name: four on which detectors are scored, three on which they are trained."""

from sumo_nets.networks import beltway, highway, mountain, sharp_turns, slow_curve, suburb, town
from sumo_nets.plan import PlanMaker

PLANS: dict[str, PlanMaker] = {
    "slow_curve": slow_curve.plan,
    "sharp_turns": sharp_turns.plan,
    "town": town.plan,
    "highway": highway.plan,
    "mountain": mountain.plan,
    "suburb": suburb.plan,
    "beltway": beltway.plan,
}
