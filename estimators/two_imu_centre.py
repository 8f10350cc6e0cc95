"""The joint centre from two IMUs on a stream, whatever the joint centre does: r_1 and r_2 may vary.

Carried to the joint centre, both specific forces are one vector. With r_i from sensor i to the joint centre, in its
axes, K_i r = w_i' x r + w_i x (w_i x r), and R from the axes of sensor 2 to those of sensor 1,

    0 = c = f_1 + K_1 r_1 - R (f_2 + K_2 r_2).

The acceleration of the joint centre is in neither side alone; nor is gravity, so none is removed. An error-state
extended Kalman filter with the state of two_imu_model.py measures both rates and c = 0. docs/moving-pivot.md has the
equations and the limits.
"""

import math
from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lapack

from imubench import rotations
from imubench.arrays import Array, frozen
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators.extent import too_short
from imubench.estimators.two_imu_model import (
    A1,
    A2,
    ACCEL_STD,
    EYE,
    GYRO_STD,
    R1,
    R2,
    STATES,
    TURN,
    W1,
    W2,
    Jerk,
    Noise,
    constraint,
    predict,
    turn,
)
from imubench.estimators.two_imu_start import CAREFUL, start
from imubench.paired import paired
from imubench.recording import Recording

NAME = "two-imu-centre"
UNKNOWNS = 9  # r of either IMU, and how they are turned to each other
INITIAL = 100  # samples that give the first state
TURNING = 50.0  # times its gyroscope's noise, the RMS rate of either segment; before, there is nothing to start from
BLOCK = 50  # samples between two corrections of P
HELD = 0.03  # m, what the filter takes an unseen direction of r to be good to
UNSEEN = 0.1  # m; a direction less sure than that has not been seen
_CROSS = np.array([np.cross(e, EYE).T for e in EYE])  # [e_k]x
_SPREAD = np.einsum("kai,lbj->ijklab", _CROSS, _CROSS).reshape(9, 81)


class TwoImuCentre:
    """One sample of both IMUs in, r_1 and r_2 out; NaN until `initial_samples` are gathered in which a segment turns.

    These give the first state by least squares (two_imu_start.py), unless `start` sets one.
    """

    def __init__(self, noise: Noise | None = None, initial_samples: int = INITIAL):
        if initial_samples < 10:
            raise InputError(f"initial_samples: expected 10 or more, got {initial_samples}")
        self.noise, self.initial_samples = noise or Noise(), initial_samples
        self.x, self.P = np.full(STATES, np.nan), np.zeros((STATES, STATES))
        self.R = EYE  # (3, 3), from the axes of sensor 2 to those of sensor 1
        self.innovation_squared = np.nan  # of the last sample, normalised; chi-square with 9 degrees of freedom
        self._gathered: deque[tuple[float, Array, Array]] | None = deque(maxlen=initial_samples)
        self._jerk: Jerk | None = None
        self._variances = self.noise.measurement()
        self._false, self._samples = np.zeros((6, 6)), 0  # information about r, of which nothing is true
        self._H = np.zeros((9, STATES))
        self._H[:6, W1.start : W2.stop] = np.eye(6)

    def start(self, x: ArrayLike, R: ArrayLike, P: ArrayLike, rates: ArrayLike, step: float) -> None:
        """Set state (21,), R (3, 3) from sensor 2 to sensor 1 and covariance (21, 21).

        `rates` (2, n, 3) in rad/s, `step` s apart, are the last ones until now; they tell how w' drifts.
        """
        self.x, self.R, self.P = (np.array(part, dtype=float) for part in (x, R, P))
        self._jerk = Jerk(self.noise, np.asarray(rates, dtype=float), step)
        self._gathered = None

    def update(self, gyro: Array, accel: Array, dt: float) -> Array:
        """Return r (2, 3) in m after one sample, as `advance` takes it."""
        self.advance(gyro, accel, dt)
        return self.answer()[0].reshape(2, 3)

    @property
    def started(self) -> bool:
        """Whether there is an answer."""
        return self._gathered is None

    def advance(self, gyro: Array, accel: Array, dt: float) -> None:
        """Take in rates in rad/s and specific forces in m/s^2, both (2, 3), of one instant.

        `dt` s is the time since the sample before; that of the first is not used. Raises `InputError` when a number is
        not finite or dt not positive; the filter is then as it was.
        """
        if not (np.isfinite(gyro).all() and np.isfinite(accel).all()):
            raise InputError(f"{NAME}: expected finite samples, got gyro {gyro}, acceleration {accel}")
        if not dt > 0 and (self._gathered is None or self._gathered):
            raise InputError(f"{NAME}: expected a time step > 0 s, got {dt!r}")
        if self._gathered is not None:
            self._gather(gyro, accel, dt)
        else:
            self._filter(gyro, accel, round(dt, 9))

    def answer(self) -> tuple[Array, Array]:
        """Return both r, stacked (6,) in m, and their covariance (6, 6): the filter's without false information.

        Where none is left, r is zero give or take `noise.r_std`, as it was before any sample. NaN before the start.
        """
        if not self.started:
            return self.x[:6], np.full((6, 6), np.nan)
        values, vectors = self._seen()
        floor = np.maximum(values, self.noise.r_std**-2)
        kept = np.maximum(values, 0.0) / floor
        return vectors.dot(kept * self.x[:6].dot(vectors)), (vectors / floor).dot(vectors.T)

    def _filter(self, gyro: Array, accel: Array, dt: float) -> None:
        assert self._jerk is not None
        x, R, F = predict(self.x, self.R, dt)
        P = F.dot(self.P).dot(F.T)
        P += self.noise.process(self._jerk.powers(gyro, dt), dt)
        leak = np.linalg.solve(P[:6, :6], self.P[:6, :6])  # r drifts, and what was known about it fades
        self._false = leak.dot(self._false).dot(leak.T)
        c, self._H[6:] = constraint(x, R, accel[0], accel[1])
        rhs = np.empty((9, STATES + 1), order="F")
        HP = rhs[:, :-1]
        HP[:] = self._H.dot(P)
        rhs[:3, -1], rhs[3:6, -1], rhs[6:, -1] = gyro[0] - x[W1], gyro[1] - x[W2], -c
        S = HP.dot(self._H.T)
        S.flat[:: 9 + 1] += self._variances
        self._count_false(P, S[6:, 6:], R)
        L, _ = lapack.dpotrf(S, 1)
        whitened, _ = lapack.dtrtrs(L, rhs, 1)
        W, y = whitened[:, :-1], whitened[:, -1]
        P -= W.T.dot(W)
        self.x, self.R, self.P = x, R, 0.5 * (P + P.T)  # rounding that is not symmetric grows without end
        self._move(y.dot(W))
        self.innovation_squared = float(y.dot(y))
        self._samples += 1
        if self._samples % BLOCK == 0:
            self._take_false_out()

    def _seen(self) -> tuple[Array, Array]:
        """Return eigenvalues (6,) and eigenvectors of the information about r that is not false."""
        values, vectors = np.linalg.eigh(np.linalg.inv(self.P[:6, :6]) - CAREFUL * self._false)
        return values, vectors

    def _count_false(self, P: Array, S: Array, R: Array) -> None:
        """Add up what errors of w' alone make of the information about r.

        H holds [w']x, of which only the estimate is known. Its error d adds [d]x^T M [d]x, M the inverse of what c
        scatters by with r known: on average the sum over k, l of A_kl [e_k]x^T M [e_l]x, A the covariance of w'.
        """
        H = self._H[6:, :6]
        M = np.linalg.inv(S - H.dot(P[:6, :6]).dot(H.T))
        for r, a, m in ((R1, A1, M), (R2, A2, R.T.dot(M).dot(R))):
            self._false[r, r] += _SPREAD.dot(np.multiply.outer(P[a, a], m).ravel()).reshape(3, 3)

    def _take_false_out(self) -> None:
        """Take false information out of the filter, too, so that it learns anew what a later motion shows.

        r moves to the answer. In directions that are not seen the filter keeps HELD instead of the answer's std: with
        more, noise would carry r about there. That, too, is information of which nothing is true.
        """
        values, vectors = self._seen()
        r, _ = self.answer()
        held = np.maximum(values, HELD**-2)
        P_r = self.P[:6, :6]
        back = np.linalg.solve(P_r, self.P[:6])  # (6, 21)
        self._move((r - self.x[:6]).dot(back))
        P = self.P + back.T.dot((vectors / held).dot(vectors.T) - P_r).dot(back)
        self.P = 0.5 * (P + P.T)
        extra = held - np.maximum(values, self.noise.r_std**-2)
        self._false = (vectors * (extra / CAREFUL)).dot(vectors.T)

    def _move(self, step: Array) -> None:
        """Add a step (21,) to the state; its turn goes into R, which is kept a rotation."""
        self.x = self.x + step
        self.x[TURN] = 0.0
        R = turn(step[TURN])[0].dot(self.R)
        self.R = 1.5 * R - 0.5 * R.dot(R.T).dot(R)

    def _gather(self, gyro: Array, accel: Array, dt: float) -> None:
        assert self._gathered is not None
        now = self._gathered[-1][0] + dt if self._gathered else 0.0
        self._gathered.append((now, frozen(gyro, (2, 3), "gyro"), frozen(accel, (2, 3), "accel")))
        if len(self._gathered) < self.initial_samples:
            return
        t, w, f = (np.array(part) for part in zip(*self._gathered, strict=True))
        turning = np.sqrt(np.mean(np.sum(w**2, axis=2), axis=0)) / self.noise.gyro_std
        if turning.max() > TURNING:
            self._begin(t, w.transpose(1, 0, 2), f.transpose(1, 0, 2))

    def _begin(self, t: Array, w: Array, f: Array) -> None:
        noise, step = self.noise, float(np.median(np.diff(t)))
        first = start(w, f, t, noise.r_std, noise.accel_std, noise.gyro_std)
        powers = Jerk(noise, w, step).powers(w[:, -1], step)
        x, P = np.zeros(STATES), np.zeros((STATES, STATES))
        x[:6] = first.r
        P[:9, :9] = first.covariance
        for i, (rate, angular) in enumerate(((W1, A1), (W2, A2))):
            std = noise.gyro_std[i]
            x[rate], x[angular] = w[i, -1], (w[i, -1] - w[i, -2]) / step
            P[rate, rate] = std**2 * EYE
            P[rate, angular] = P[angular, rate] = std**2 / step * EYE
            P[angular, angular] = 2 * (std / step) ** 2 * EYE + powers[i] * step
        self.start(x, rotations.to_matrix(first.quaternion), P, w, step)
        self._take_false_out()


def noise_of(recording: Recording) -> Noise:
    """Return the noise that a recording declares; none at all counts as very little."""
    imus = recording.imu("imu1"), recording.imu("imu2")
    gyro, accel = (
        [default if std is None else max(std, least) for std in stds]
        for stds, default, least in (
            ([i.gyro_noise_std for i in imus], GYRO_STD, 1e-5),
            ([i.accel_noise_std for i in imus], ACCEL_STD, 1e-4),
        )
    )
    return replace(Noise(), gyro_std=(gyro[0], gyro[1]), accel_std=math.hypot(*accel))


def estimate(recording: Recording, noise: Noise | None = None, initial_samples: int = INITIAL) -> Estimate:
    """Estimate r (n, 2, 3) in m of both IMUs, one pair per sample from the last of the initial ones on.

    Raises `InputError` with fewer than two IMUs, or fewer samples than it starts with.
    """
    samples = paired(recording)
    n = samples.time.size
    if n <= initial_samples:
        raise InputError(f"{recording.name}: {NAME} expected more than {initial_samples} samples of both IMUs, got {n}")
    centre = TwoImuCentre(noise or noise_of(recording), initial_samples)
    gyro = np.stack([samples.gyro1, samples.gyro2], axis=1)
    accel = np.stack([samples.accel1, samples.accel2], axis=1)
    r, P, squares = np.empty((n, 6)), np.empty((n, 6, 6)), np.full(n, np.nan)
    first = n
    for k, dt in enumerate(np.diff(samples.time, prepend=samples.time[0]).tolist()):
        centre.advance(gyro[k], accel[k], dt)
        if centre.started:
            first = min(first, k)
            (r[k], P[k]), squares[k] = centre.answer(), centre.innovation_squared
    details = {"samples": float(n), "first_answer": float(first)}
    why = too_short(samples.time, UNKNOWNS) or ("neither segment turned enough to start with" if first > n - 2 else "")
    if why:
        return Estimate("joint_vector", NAME, np.zeros((2, 3)), None, why, "not identifiable", details=details)
    stds = np.sqrt([np.linalg.eigvalsh(P[-1, i : i + 3, i : i + 3]) for i in (0, 3)])  # (2, 3) m, ascending
    details["innovation_squared"] = float(squares[first + 1 :].mean() / 9)
    details |= {f"worst_std_imu{i + 1}": float(stds[i, 2]) for i in range(2)}
    if (stds[:, 1] > UNSEEN).all():  # of a hinge, one direction of either is allowed to stay open
        why = f"of neither IMU two directions of r are seen to {UNSEEN:g} m: the segments turned too little"
        return Estimate("joint_vector", NAME, r[-1].reshape(2, 3), None, why, "not identifiable", details=details)
    value = r[first:].reshape(-1, 2, 3)
    return Estimate("joint_vector", NAME, value, P[first:], time=samples.time[first:], details=details)
