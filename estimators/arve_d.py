"""ArVE_d: r, r', angular rate and angular acceleration by an extended Kalman filter; r' drifts.

Garcia de Villa et al., section III-A.
"""

from numpy.typing import ArrayLike

from imubench.estimate import Estimate
from imubench.estimators.centre_answer import answer
from imubench.estimators.centre_ekf import INITIAL, CentreFilter, Covariances, covariances_of
from imubench.estimators.gravity import How
from imubench.recording import Recording

STATES = 12


class ArveD(CentreFilter):
    """ArVE_d on a stream: `update` takes one sample and returns one r (3,) in m.

    `covariances` default to those for an r that varies and a known orientation.
    """

    def __init__(
        self, covariances: Covariances | None = None, r0: ArrayLike | None = None, initial_samples: int = INITIAL
    ):
        super().__init__(STATES, covariances or covariances_of("arve-d"), r0, initial_samples)


def estimate(
    recording: Recording,
    gravity: How = "ukf",
    covariances: Covariances | None = None,
    r0: ArrayLike | None = None,
    initial_samples: int = INITIAL,
) -> Estimate:
    """Estimate r (n, 1, 3) in m, one per sample from the last of the initial ones on, of a recording with one IMU.

    `covariances` default to those for a varying r and this `gravity`; with `r0` (3,) in m every sample has an answer.
    """
    covariances = covariances or covariances_of("arve-d", gravity=gravity)
    return answer("arve-d", ArveD(covariances, r0, initial_samples), recording, gravity)
