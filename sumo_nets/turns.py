"""Which lane leads to which across a junction, and who has to give way."""

from __future__ import annotations

import itertools
import math

from sumo_nets.plan import Arm, Junction, LaneLink

STRAIGHT_RAD = math.radians(40)
UTURN_RAD = math.radians(165)


def lane_links(junction: Junction, arms: list[Arm]) -> list[LaneLink]:
    """Explicit links where a junction has some, otherwise the turns that the arms' headings make."""
    if junction.links:
        return list(junction.links)
    return [link for arm in arms if arm.lanes_in for link in _links_from(arm, arms)]


def _links_from(arm: Arm, arms: list[Arm]) -> list[LaneLink]:
    """Right turns from the rightmost lane, left turns from the leftmost, the others straight on."""
    exits = [(turn_angle(arm, other), other) for other in arms if other is not arm and other.lanes_out]
    rights = [other for angle, other in exits if -UTURN_RAD < angle < -STRAIGHT_RAD]
    lefts = [other for angle, other in exits if STRAIGHT_RAD < angle < UTURN_RAD]
    straights = [other for angle, other in exits if abs(angle) <= STRAIGHT_RAD]
    count = arm.lanes_in
    links = [LaneLink(arm.street.id, 0, other.street.id, 0) for other in rights]
    links += [LaneLink(arm.street.id, count - 1, other.street.id, other.lanes_out - 1) for other in lefts]
    for other in straights:
        lanes = range(count - 1) if lefts and count >= 3 else range(count)
        links += [LaneLink(arm.street.id, lane, other.street.id, lane) for lane in lanes if lane < other.lanes_out]
    used = {link.from_lane for link in links}
    for lane in range(count):
        if lane in used:
            continue
        for other in lefts or straights or rights:
            target = max(0, other.lanes_out - (count - lane))
            links.append(LaneLink(arm.street.id, lane, other.street.id, target))
    return links


def turn_angle(arm: Arm, other: Arm) -> float:
    """Change of heading (rad, left positive) from one arm into another."""
    difference = other.pose[2] + math.pi - arm.pose[2]
    return math.atan2(math.sin(difference), math.cos(difference))


def major_arms(arms: list[Arm]) -> list[Arm]:
    """Return the arms with the right of way: the highest rank, or among equals the two most nearly in line."""
    top = max(arm.street.rank for arm in arms)
    highest = [arm for arm in arms if arm.street.rank == top]
    if len(highest) < len(arms) or len(arms) < 3:
        return highest
    pairs = itertools.combinations(arms, 2)
    return list(min(pairs, key=lambda pair: abs(turn_angle(*pair))))
