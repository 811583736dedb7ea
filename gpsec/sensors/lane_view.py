"""The lane as an ideal camera sees it, and how well a polynomial can be fitted to what is in view."""

from math import cos, sqrt, tan

from gpsec.core.kernels import inline

# Diagonal of the inverse of the 4 x 4 Hilbert matrix, over its first element: the relative variances of C0 … C3
# of a cubic fitted by least squares to equally spaced points on [0, 1].
_SLOPE, _BEND, _TWIST = sqrt(1200.0 / 16.0), sqrt(6480.0 / 16.0), sqrt(2800.0 / 16.0)


@inline
def lane_polynomial(offset_m: float, turn_rad: float, curvature_per_m: float) -> tuple[float, float, float, float]:
    """Return C0 … C3 (Eq 1) of the centre of a lane of constant curvature, in the vehicle frame at the rear axle.

    `offset_m` is the distance of the rear axle from the centre, across the lane and left positive; `turn_rad` the
    direction of the lane minus yaw, within ±90°. The offset along the vehicle's lateral axis is offset/cos(turn)
    (Eq 6), to the right of a vehicle that is left of the centre. y'' = κ(1 + y'²)^(3/2) gives C2 = y''/2 and,
    with κ' = 0, C3 = y'''/6 = κ² y'(1 + y'²)²/2.
    """
    cosine = cos(turn_rad)
    slope = tan(turn_rad)
    bend = curvature_per_m / (2.0 * cosine * cosine * cosine)
    twist = curvature_per_m * curvature_per_m * slope / (2.0 * cosine * cosine * cosine * cosine)
    return -offset_m / cosine, slope, bend, twist


@inline
def view_length_m(range_m: float, half_view_rad: float, curvature_per_m: float) -> float:
    """Return the length of lane in view: an arc leaves a field of view of ±φ where its chord has turned by φ.

    The chord to arc length s has turned by κ·s/2, so that this is at 2φ/|κ|.
    """
    bend = abs(curvature_per_m)
    if bend * range_m <= 2.0 * half_view_rad:
        return range_m
    return 2.0 * half_view_rad / bend


@inline
def fit_sigmas(white_m: float, range_m: float, view_m: float) -> tuple[float, float, float, float]:
    """Return σ of C0 … C3, given σ `white_m` of C0 when the whole range is in view.

    A cubic fitted to points of constant density on a length r has Var(Ci) proportional to r^-(2i+1).
    """
    sigma = white_m * sqrt(range_m / view_m)
    return (
        sigma,
        sigma * _SLOPE / view_m,
        sigma * _BEND / (view_m * view_m),
        sigma * _TWIST / (view_m * view_m * view_m),
    )
