"""The hinge axis from gyroscopes alone by Seel, Schauer and Raisch, IEEE CCA 2012, pages 45-49."""

import numpy as np

from imubench.estimate import Estimate, Pairing
from imubench.estimators.extent import too_short
from imubench.estimators.hinge_constraints import weigh
from imubench.estimators.hinge_fit import descend
from imubench.estimators.olsson2020 import SAME, STARTS, UNKNOWNS, answer, deviation
from imubench.estimators.pairing import told_by_mounts, toward_y
from imubench.paired import paired
from imubench.recording import Recording


def estimate(recording: Recording) -> Estimate:
    """Minimise the sum of (|w1 x j1| - |w2 x j2|)^2 over the two axes (2, 3), by Gauss-Newton on the sphere.

    The cost is the same for (j1, j2) and (j1, -j2): gyroscopes cannot tell the sign pairing, and the
    method has nothing to say about it. Each axis gets the sign that points along +y of its segment as
    the declared mounts have it, as a person who knows roughly how the sensors sit would; where they are
    not declared well enough, `pairing` is `unknown` and the signs mean nothing. `not identifiable` where
    the IMUs share too few samples. Raises `InputError` with fewer than two IMUs.
    """
    samples = paired(recording)
    none = np.zeros((0, 3))
    c = weigh(samples.gyro1, samples.gyro2, none, none)
    minima = sorted((descend(c, start) for start in STARTS), key=lambda minimum: minimum.cost)
    best = minima[0]
    axes = toward_y(recording, best.axes)
    apart = np.array([deviation(toward_y(recording, minimum.axes), axes) for minimum in minima])
    details = {
        "cost": best.cost,
        "iterations": float(best.iterations),
        "samples": float(samples.time.size),
        "starts": float(len(STARTS)),
        "starts_agreeing": float(np.sum(apart < SAME)),
        "spread": float(apart.max()),  # rad
        "gyro_residual_std": best.gyro_std,  # rad/s
    }
    pairing: Pairing = "from declared mounts" if told_by_mounts(recording, axes) else "unknown"
    return answer("seel2012", c, best, axes, details, pairing, too_short(samples.time, UNKNOWNS))
