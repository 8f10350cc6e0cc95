"""One r a sample by gradient descent, after Frick and Rahmatalla, as far as others describe it.

Garcia de Villa et al., sections I, II and IV, say of Frick and Rahmatalla (Sensors 18 (2018) 1089 and 2563): low-pass
filtered signals, w' by analytic derivation, an r at each time instant by gradient descent, started from the whole
record. The rest is our choice: docs/papers.md.
"""

from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array, frozen
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators.gravity import How, linear_acceleration
from imubench.estimators.mrvs import lever_matrix, only_imu, solve, why_unidentifiable
from imubench.recording import Recording

NAME = "frick-rahmatalla"
HALF = 4  # samples on either side of the one that a local parabola smooths
SAME = 1e-10  # s, by which stamps may differ for a parabola to be that of the sample before
STEPS = 3  # of descent for each sample; both are the best of 36 pairs on the one run that reproduce/arve/fit.py names
NO_COVARIANCE = (
    "a few steps of descent follow r only in part; how far they lag behind, most of the error, no residual tells"
)


def smooth(samples: ArrayLike, time: ArrayLike, half: int = HALF) -> tuple[Array, Array]:
    """Return value and slope (..., n - 2 half, 3) of the parabola through samples (..., n, 3) around each inner one.

    That is the low-pass filter and the analytic derivative in one. Stamps (n,) s need not be even.
    """
    x, t = np.asarray(samples, dtype=float), np.asarray(time, dtype=float)
    width = 2 * half + 1
    weights = parabola(np.lib.stride_tricks.sliding_window_view(t, width) - t[half : t.size - half, None])
    windows = np.lib.stride_tricks.sliding_window_view(x, width, axis=-2)  # (..., windows, 3, width)
    value, slope = (np.einsum("...kiw,kw->...ki", windows, weights[:, i]) for i in range(2))
    return value, slope


def parabola(offsets: Array) -> Array:
    """Return the weights (..., 2, width) by which samples at `offsets` (..., width) s make value and slope at 0 s."""
    return np.asarray(np.linalg.pinv(offsets[..., None] ** np.arange(3))[..., :2, :])


def descend(M: Array, a: Array, r: Array, steps: int = STEPS) -> Array:
    """Return r (..., 3) in m after steps of descent on |a + M r|^2 of one sample, M (..., 3, 3), a (..., 3).

    Each step goes along the gradient just as far as lowers the cost most: its length adapts to the sample.
    """
    for _ in range(steps):
        g = np.einsum("...ij,...i->...j", M, a + np.einsum("...ij,...j->...i", M, r))
        Mg = np.einsum("...ij,...j->...i", M, g)
        length = np.sum(g * g, axis=-1) / np.maximum(np.sum(Mg * Mg, axis=-1), 1e-30)  # Mg = 0 only where g = 0
        r = r - length[..., None] * g
    return r


def follow(
    gyro: ArrayLike,
    acceleration: ArrayLike,
    time: ArrayLike,
    r0: ArrayLike | None = None,
    half: int = HALF,
    steps: int = STEPS,
) -> Array:
    """Return r (..., n - 2 half, 3) in m at the inner samples of w, a (..., n, 3); leading axes are runs.

    `r0` (..., 3) in m; None: least squares over all samples.
    """
    w, angular = smooth(gyro, time, half)
    a = smooth(acceleration, time, half)[0]
    M = lever_matrix(w, angular)
    start = solve(w, angular, a)[0] if r0 is None else np.asarray(r0, dtype=float)
    r = np.nan_to_num(np.broadcast_to(start, (*a.shape[:-2], 3)))
    answers = np.empty(a.shape)
    for k in range(a.shape[-2]):
        r = descend(M[..., k, :, :], a[..., k, :], r, steps)
        answers[..., k, :] = r
    return answers


class FrickRahmatalla:
    """The same on a stream: one sample in, one r out, that of the sample `half` before; NaN until there is one."""

    def __init__(self, r0: ArrayLike, half: int = HALF, steps: int = STEPS):
        if half < 1 or steps < 1:
            raise InputError(f"{NAME}: expected half and steps of 1 or more, got {half} and {steps}")
        self.r = frozen(r0, (3,), "r0")
        self.half, self.steps = half, steps
        self._time = 0.0
        self._samples: deque[tuple[float, Array, Array]] = deque(maxlen=2 * half + 1)
        self._offsets, self._weights = np.full(2 * half + 1, np.nan), np.empty((2, 2 * half + 1))

    def update(self, gyro: ArrayLike, acceleration: ArrayLike, dt: float) -> Array:
        """Return r (3,) in m after w (3,) in rad/s and a (3,) in m/s^2, `dt` s after the sample before."""
        w, a = frozen(gyro, (3,), "gyro"), frozen(acceleration, (3,), "acceleration")
        if self._samples and not dt > 0:
            raise InputError(f"{NAME}: expected a time step > 0 s, got {dt!r}")
        self._time += dt
        self._samples.append((self._time, w, a))
        if len(self._samples) <= 2 * self.half:
            return np.full(3, np.nan)
        t, rates, accelerations = (np.array(x) for x in zip(*self._samples, strict=True))
        offsets = t - t[self.half]
        if not np.abs(offsets - self._offsets).max() < SAME:
            self._offsets, self._weights = offsets, parabola(offsets)
        rate, angular = self._weights @ rates
        self.r = descend(lever_matrix(rate, angular), self._weights[0] @ accelerations, self.r, self.steps)
        return self.r


def estimate(recording: Recording, gravity: How = "ukf", r0: ArrayLike | None = None) -> Estimate:
    """Estimate r (n, 1, 3) in m, one per inner sample of a recording with one IMU, without a covariance.

    `r0` (3,) in m; None: least squares over the whole record, which makes it an off-line method.
    """
    imu = only_imu(recording, NAME)
    n = imu.time.size
    if n < 2 * HALF + 1:
        raise InputError(f"{recording.name}: {NAME} expected {2 * HALF + 1} samples or more, got {n}")
    acceleration = linear_acceleration(recording, gravity)
    r = follow(imu.gyro, acceleration, imu.time, r0)
    details = {"samples": float(n)}
    why = why_unidentifiable(imu, acceleration)
    if why:
        mean = r.mean(axis=0)[None]
        return Estimate("joint_vector", NAME, mean, None, why, "not identifiable", details=details)
    time = imu.time[HALF : n - HALF]
    return Estimate("joint_vector", NAME, r[:, None], None, NO_COVARIANCE, time=time, details=details)
