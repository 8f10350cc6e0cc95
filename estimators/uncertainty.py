"""How sure an estimate of the hinge axes is: Olsson 2020, section 6, for one estimate and for a sequence of them.

Angles are those by which an axis may be off, eq. (59). Steps (theta1, phi1, theta2, phi2) are in the chart around
the estimate (see `spherical`): at its origin a step is an angle, so no pole inflates an uncertainty.
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from scipy.special import ellipe

from imubench.arrays import Array
from imubench.estimators.hinge_fit import Solution, scaled_information
from imubench.rotations import angle_between

SINGULAR = 1e-12  # smallest part of the largest eigenvalue of the information that is not rounding
UNBOUNDED = math.pi  # rad, the uncertainty of an axis that nothing holds: no angle is larger


def paper_covariance(s: Solution) -> Array | None:
    """Return P_x (4, 4) in rad^2, Olsson 2020, eq. (57), or None where the information is singular.

    It is that of residuals weighted by 1 / std, away from planar motion; `hinge_fit.covariance` holds there, too.
    """
    information = scaled_information(s)
    values, vectors = np.linalg.eigh(information)
    if not (np.isfinite(values).all() and values[0] > SINGULAR * values[-1] > 0):
        return None
    return np.asarray((vectors / values) @ vectors.T)


def deviations(steps: Array) -> Array:
    """Return z = h(x) (..., 2) in rad, eq. (60): how far steps (..., 4) in rad turn either axis.

    cos z = cos(theta) cos(phi), by the arc tangent because z is small.
    """
    theta, phi = steps[..., 0::2], steps[..., 1::2]
    sine = np.hypot(np.sin(theta), np.cos(theta) * np.sin(phi))
    return np.asarray(np.arctan2(sine, np.cos(theta) * np.cos(phi)))


def monte_carlo(covariance: Array, rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Return mu_z (2,) and sigma_z (2,) in rad from `count` draws of N(0, P_x), eq. (62) to (65)."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    z = deviations(rng.standard_normal((count, 4)) @ root.T)
    return z.mean(axis=0), z.std(axis=0, ddof=1)


def small_angle(covariance: Array) -> tuple[Array, Array]:
    """Return mu_z (2,) and sigma_z (2,) in rad in closed form, for covariances (4, 4) of small angles.

    z^2 = theta^2 + phi^2 has the mean l1 + l2, with the eigenvalues l1 >= l2 of one axis' 2x2 block, and z the
    mean sqrt(2 l1 / pi) E(1 - l2 / l1), with the complete elliptic integral of the second kind.
    """
    blocks = np.stack([covariance[:2, :2], covariance[2:, 2:]])
    low, high = np.maximum(np.linalg.eigvalsh(blocks), 0.0).T
    ratio = low / np.where(high > 0, high, 1.0)
    mean = np.sqrt(2.0 * high / np.pi) * ellipe(1.0 - ratio)
    return mean, np.sqrt(np.maximum(low + high - mean**2, 0.0))


def two_sigma(covariance: Array) -> Array:
    """Return mu_z + 2 sigma_z (2,) in rad in closed form, for small angles."""
    mean, std = small_angle(covariance)
    return np.asarray(mean + 2.0 * std)


def of_axes(covariance: Array, s: Solution, axes: Array) -> Array:
    """Return the covariance (6, 6) of `axes` (2, 3), those of `s` up to their signs, from that of steps (4, 4)."""
    flips = np.sign(np.sum(axes * s.axes, axis=1))
    turned = np.zeros((6, 4))
    for i in range(2):
        turned[3 * i : 3 * i + 3, 2 * i : 2 * i + 2] = flips[i] * s.tangents[i].T
    return turned @ covariance @ turned.T


def local_uncertainty(covariance: Array | None, rng: np.random.Generator, count: int) -> Array:
    """Return mu_z + 2 sigma_z (2,) in rad for either axis, section 6.1; pi without a covariance."""
    if covariance is None:
        return np.full(2, UNBOUNDED)
    mean, std = monte_carlo(covariance, rng, count)
    return np.asarray(mean + 2.0 * std)


def signed_like(axes: Array, previous: Array) -> Array:
    """Return +axes or -axes (2, 3), whichever has one axis nearest to what it was before, eq. (66)."""
    nearest = [angle_between(sign * axes, previous).min() for sign in (1.0, -1.0)]
    return axes if nearest[0] <= nearest[1] else -axes


def sequential_deviation(axes: Array, previous: Array | None) -> float:
    """Return SEQAD in rad, eq. (67), of axes (2, 3) signed like the previous ones; pi for the first."""
    return math.pi if previous is None else float(angle_between(axes, previous).max())


@dataclass(frozen=True)
class Verdict:
    """What Algorithm 4 makes of one more estimate."""

    axes: Array  # (2, 3) signed like the estimate before
    seqad: float  # rad, eq. (67)
    worst_seqad: float  # rad, of the last n_min estimates, eq. (68)
    local: Array  # (2,) rad, mu_z + 2 sigma_z
    accepted: bool


class Acceptance:
    """Algorithm 4 of Olsson 2020 without its solver: estimate after estimate goes in, and is accepted or not.

    An estimate is accepted if either axis has mu_z + 2 sigma_z < `e_max` (rad) and the last `n_min` estimates,
    from random starts, each came out within `e_max` of the one before. The first estimate counts as pi off.
    """

    def __init__(self, e_max: float, n_min: int):
        self.e_max = e_max
        self._recent = deque([math.pi] * n_min, maxlen=n_min)
        self._previous: Array | None = None

    def update(self, axes: Array, local: Array) -> Verdict:
        """Judge the next axes (2, 3) with their mu_z + 2 sigma_z (2,) in rad."""
        if self._previous is not None:
            axes = signed_like(axes, self._previous)
        seqad = sequential_deviation(axes, self._previous)
        self._previous = axes
        self._recent.append(seqad)
        worst = max(self._recent)
        accepted = bool((local < self.e_max).all() and worst < self.e_max)
        return Verdict(axes, seqad, worst, local, accepted)
