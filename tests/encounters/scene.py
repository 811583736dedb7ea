import numpy as np

from gpsec.encounters.rectangles import Bodies


def bodies(*cars):
    """Bodies of (x, y, course in degrees, speed); 4 m long and 2 m wide."""
    x, y, course, speed = (np.array(values, float) for values in zip(*cars, strict=True))
    ux, uy = np.cos(np.radians(course)), np.sin(np.radians(course))
    return Bodies(x, y, ux, uy, np.full(len(x), 2.0), np.full(len(x), 1.0), speed * ux, speed * uy)


def random_bodies(count, side_m, seed=1):
    rng = np.random.default_rng(seed)
    yaw = rng.uniform(-np.pi, np.pi, count)
    speed = np.where(rng.random(count) < 0.2, 0.0, rng.uniform(0.0, 40.0, count))
    return Bodies(
        rng.uniform(-side_m, side_m, count),
        rng.uniform(-side_m, side_m, count),
        np.cos(yaw),
        np.sin(yaw),
        rng.uniform(0.5, 9.0, count),
        rng.uniform(0.3, 1.5, count),
        speed * np.cos(yaw),
        speed * np.sin(yaw),
    )
