"""The vehicle types of all scenarios: bodies and drivers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Body:
    """Dimensions (m), dynamics (m/s, m/s2) and share of the traffic of a kind of vehicle."""

    vehicle_class: str
    shape: str
    length: float
    width: float
    accel: float
    decel: float
    max_speed: float
    share: float
    colour: str
    steadiness: float = 1.0
    """Scales how much a driver wanders in the lane: large vehicles have less room."""


@dataclass(frozen=True)
class Driver:
    """A kind of driver; `align_m` is the preferred offset in the lane, left positive."""

    share: float
    speed_factor: str
    sigma: float
    tau: float
    min_gap: float
    assertive: float
    gap_lateral: float
    lateral_sigma: float
    align_m: float


BODIES = {
    "small": Body("passenger", "passenger/hatchback", 3.7, 1.65, 2.4, 4.5, 50.0, 0.24, "120,170,220"),
    "sedan": Body("passenger", "passenger/sedan", 4.6, 1.82, 2.8, 4.5, 55.0, 0.33, "200,200,205"),
    "suv": Body("passenger", "passenger/wagon", 5.0, 2.0, 2.6, 4.5, 55.0, 0.22, "90,110,100"),
    "van": Body("delivery", "delivery", 5.9, 2.02, 1.9, 4.2, 42.0, 0.1, "235,235,235", 0.8),
    "truck": Body("truck", "truck", 9.6, 2.5, 1.1, 3.8, 25.0, 0.07, "190,120,60", 0.6),
    "bus": Body("bus", "bus", 12.0, 2.55, 1.1, 3.8, 25.0, 0.04, "220,180,40", 0.6),
}

DRIVERS = {
    "calm": Driver(0.3, "normc(0.92,0.05,0.8,1.0)", 0.3, 1.5, 2.8, 0.8, 0.7, 0.24, -0.12),
    "normal": Driver(0.5, "normc(1.0,0.06,0.85,1.15)", 0.4, 1.2, 2.5, 1.0, 0.6, 0.24, 0.04),
    "hurried": Driver(0.2, "normc(1.1,0.06,0.95,1.25)", 0.5, 1.0, 2.0, 1.3, 0.5, 0.24, 0.18),
}

PROFESSIONAL = ("calm", "normal")
"""Who drives trucks and buses."""


def document() -> str:
    """Return the additional file with every type and the distribution `traffic`."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<additional>", '    <vTypeDistribution id="traffic">']
    for body_name, body in BODIES.items():
        drivers = PROFESSIONAL if body.vehicle_class in {"truck", "bus"} else tuple(DRIVERS)
        total = sum(DRIVERS[name].share for name in drivers)
        lines += [_vtype(f"{body_name}_{name}", body, DRIVERS[name], total) for name in drivers]
    lines += ["    </vTypeDistribution>", "</additional>", ""]
    return "\n".join(lines)


def _vtype(name: str, body: Body, driver: Driver, total: float) -> str:
    """One vehicle type with one kind of driver."""
    attributes = {
        "id": name,
        "vClass": body.vehicle_class,
        "guiShape": body.shape,
        "length": body.length,
        "width": body.width,
        "accel": body.accel,
        "decel": body.decel,
        "emergencyDecel": 8.0,
        "maxSpeed": body.max_speed,
        "speedFactor": driver.speed_factor,
        "sigma": driver.sigma,
        "tau": driver.tau,
        "minGap": driver.min_gap,
        "minGapLat": driver.gap_lateral,
        "maxSpeedLat": 0.9,
        "latAlignment": round(driver.align_m * body.steadiness, 3),
        "lcSigma": round(driver.lateral_sigma * body.steadiness, 3),
        "lcAssertive": driver.assertive,
        "lcAccelLat": 0.7,
        "lcStrategic": 3.0,
        "lcPushy": 0.0,
        "probability": round(body.share * driver.share / total, 4),
        "color": body.colour,
    }
    text = " ".join(f'{key}="{value}"' for key, value in attributes.items())
    return f"        <vType {text}/>"
