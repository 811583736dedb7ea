"""How noisy the sensors of a vehicle are, learnt from its own whitened samples.

What is learnt is the logarithm of a factor on the variance of a data sheet. A sample whose square is above its mean
raises it, one below lowers it, with a time constant. Squares are cut, so that a wild fix counts for no more than a bad
one, and the factor is bounded: noise that an attacker adds is not believed for long.
"""

from math import log

from gpsec.core.kernels import inline

# Time constant, where squares of samples are cut, and the mean of such a cut square of a standard normal number.
_LEARNING_S, _CUT = 20.0, 6.0
MEAN_CUT_SQUARE = 0.9384
# A variance is not believed to be lower than this share of the data sheet's; where an attacker counts, not to be higher
# than so many times it.
_LEAST = 0.7
MOST_VARIANCE = 2.5


@inline
def cut_square(w: float) -> float:
    """Return the square of a whitened sample, as far as it counts."""
    return min(w * w, _CUT)


@inline
def learning_gain(sample_s: float) -> float:
    """Return what a sample counts for, of which one comes every `sample_s`."""
    return 0.5 * sample_s / _LEARNING_S


@inline
def learnt(before: float, gain: float, excess: float, most: float) -> float:
    """Return the logarithm of a factor after a sample whose cut squares are by `excess` above their mean.

    The factor is kept between `_LEAST` and `most`.
    """
    return min(max(before + gain * excess, log(_LEAST)), log(most))
