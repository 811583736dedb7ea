"""Three vehicles whose every figure can be worked out by hand.

Steps of 0.1 s; time is 0.1 s after step 0. Lane 3.5 m, vehicles 1.8 m wide: a line is touched beyond 0.85 m, the lane
is left beyond 1.75 m, and with nothing beside it the road beyond 2.65 m. The vehicles go east.

a and b (profile dsd) are observed in steps 0 to 9 and attacked from step 4 on, a up to step 7, b to its end; c
(profile carla) lives through 5 steps and is never attacked.
"""

from .scene import Scene

# CUSUM's alarms of a, without the attack and with it; b and c never have any.
A_BENIGN = "--A-------"
A_ATTACKED = "--A--AAAA-"
# Cross-track error of a under cusum+ukf in the steps of the attack; under never+none it is (4, -3) m.
A_ERRORS = {5: 1.0, 6: 1.0}


def tell() -> Scene:
    """Return the scene after its end, every track closed."""
    scene = Scene(capacity=5)
    scene.vehicles.profile[4] = 1
    a, b, a_attacked, b_attacked, c = range(5)
    for step in range(10):
        if step == 4:
            scene.fork(a, a_attacked, 1, step)
            scene.fork(b, b_attacked, 1, step)
        if step == 8:
            scene.end_attack(a_attacked, step)
        scene.alarm[a, 0] = A_BENIGN[step] == "A"
        scene.alarm[a_attacked, 0] = A_ATTACKED[step] == "A"
        scene.statistic[:, 0] = 1.0 + scene.alarm[:, 0]
        scene.estimate_m[:] = 0.0
        if 4 <= step < 8:
            scene.estimate_m[a_attacked, 0, 1] = A_ERRORS.get(step, 0.0)
            scene.estimate_m[a_attacked, 1] = 4.0, -3.0
        scene.isolated[a_attacked, 0] = 5 <= step <= 8
        rows = [a, b] + [a_attacked, b_attacked] * (step >= 4) + [c] * (step < 5)
        scene.observe(step, rows)
        if step == 4:
            scene.close(c, "c", profile=1, depart_s=0.1, arrive_s=0.6)
    scene.close(b_attacked, "b", arrive_s=1.1)
    scene.close(b, "b", arrive_s=1.1)
    scene.close(a, "a")
    scene.close(a_attacked, "a")
    return scene
