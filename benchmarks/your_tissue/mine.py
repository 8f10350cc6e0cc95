"""An estimator of one's own, outside the package."""

import numpy as np
from scipy.optimize import least_squares

from imubench.estimate import Estimate
from imubench.paired import paired


def estimate(recording):
    """Return the axes across which both gyroscopes turn equally fast; how their signs pair they cannot tell."""
    both = paired(recording)
    gyro = np.stack([both.gyro1, both.gyro2])

    def axes(x):
        return x.reshape(2, 3) / np.linalg.norm(x.reshape(2, 3), axis=1, keepdims=True)

    def apart(x):
        return np.subtract(*np.linalg.norm(np.cross(gyro, axes(x)[:, None]), axis=2))

    found = axes(least_squares(apart, np.ones(6)).x)
    return Estimate("joint_axis", "mine", found, None, "not worked out", pairing="unknown")
