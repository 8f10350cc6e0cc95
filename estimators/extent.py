"""Whether a recording is long enough for an estimate to say how sure it is."""

import numpy as np

from imubench.arrays import Array

SPARE = (
    10  # samples beyond the unknowns: the noise, taken from what the fit leaves, is then known to 22 % (1 / sqrt(20))
)
SHORTEST = (
    1.0  # s, a period of a hand's motion: in less, rates and attitude hardly change, whatever the number of samples
)
ROUNDING = 1e-6  # of a second, in a sum of periods


def too_short(time: Array, unknowns: int) -> str:
    """Return why samples at `time` (n,) s, of both IMUs where there are two, are too few for so many unknowns.

    As few samples as unknowns leave no residual: any fit is then perfect, and seems certain. Empty where they suffice.
    """
    count = time.size
    period = float(np.median(np.diff(time))) if count > 1 else 0.0
    span = float(time[-1] - time[0]) + period if count else 0.0
    if count < unknowns + SPARE:
        return f"{count} samples are too few for {unknowns} unknowns and their noise, {unknowns + SPARE} are needed"
    if span < SHORTEST - ROUNDING:
        return f"{count} samples in {span:.3g} s are too short a stretch: {SHORTEST:g} s of motion is needed"
    return ""
