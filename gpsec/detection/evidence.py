"""What speaks against fixes: sums of whitened channels over four time scales (a GLR test against an unknown mean).

For a decay λ and a channel with whitened samples w,

    A ← λ·A + w        N ← λ²·N + 1        W ← λ·W + 1

in steps in which the channel has a sample. A²/N is twice the logarithm of the likelihood ratio of the mean A/W against
0, and the statistic is the largest, over λ, of its sum over the channels.

Source: A. S. Willsky and H. L. Jones, "A generalized likelihood ratio approach to the detection and estimation of jumps
in linear systems", IEEE TAC 21(1), 1976; banks of cumulative innovations against spoofing: J. D. Quartararo and S. E.
Langel, NAVIGATION 69(1), 2022.
"""

from gpsec.core.arrays import Flags, Floats
from gpsec.core.kernels import inline

# λ of each scale: one sample, and means over about 2.5, 6.7 and 20 of them.
FORGETTING = (0.0, 0.6, 0.85, 0.95)
# Channels: innovation along, innovation across, camera, and whether the map has no lane that the camera sees.
ALONG_CHANNEL, ACROSS_CHANNEL, CAMERA_CHANNEL, UNMATCHED_CHANNEL = 0, 1, 2, 3
CHANNEL_COUNT = 4
# Where A, N and W are in the (3, scales, channels) sums of a track.
_A, _N, _W = 0, 1, 2
# A sample contradicts a mean where it is e³ times as likely without.
_CONTRADICTS = -3.0


@inline
def weigh(sums: Floats, w: Floats, there: Flags, alone: bool) -> tuple[float, float]:
    """Take (channels,) samples where they are `there`; return the statistics of all channels, and of the innovations.

    Where samples stand `alone`, only the scale of one sample is used, and the sums of the others are left as they are.
    """
    joint, innovation = 0.0, 0.0
    for scale in range(1 if alone else len(FORGETTING)):
        decay = FORGETTING[scale]
        total = 0.0
        for c in range(CHANNEL_COUNT):
            if there[c]:
                sums[_A, scale, c] = decay * sums[_A, scale, c] + w[c]
                sums[_N, scale, c] = decay * decay * sums[_N, scale, c] + 1.0
                sums[_W, scale, c] = decay * sums[_W, scale, c] + 1.0
            if sums[_N, scale, c] > 0.0 and (there[c] or scale > 0):
                total += sums[_A, scale, c] ** 2 / sums[_N, scale, c]
            if c == ACROSS_CHANNEL:
                innovation = max(innovation, total)
        joint = max(joint, total)
    return joint, innovation


@inline
def drop_channel(sums: Floats, channel: int) -> None:
    """Forget the samples of one channel."""
    for part in range(3):
        for scale in range(len(FORGETTING)):
            sums[part, scale, channel] = 0.0


@inline
def is_contradicted(sums: Floats, w: Floats, there: Flags) -> bool:
    """Return whether samples speak against the mean that the scale with the most evidence has."""
    best, most = 0, 0.0
    for scale in range(len(FORGETTING)):
        total = 0.0
        for c in range(CHANNEL_COUNT):
            if sums[_N, scale, c] > 0.0:
                total += sums[_A, scale, c] ** 2 / sums[_N, scale, c]
        if total > most:
            most, best = total, scale
    gain = 0.0
    for c in range(CHANNEL_COUNT):
        if there[c] and sums[_W, best, c] > 0.0:
            mean = sums[_A, best, c] / sums[_W, best, c]
            gain += mean * w[c] - 0.5 * mean * mean
    return bool(gain < _CONTRADICTS)
