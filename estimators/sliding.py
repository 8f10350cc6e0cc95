"""The joint centre from one IMU that slides or hangs on soft tissue: r(t) over a record, or on a stream.

Three kinds of r are fitted, each a constant at its simplest: oscillations of unknown frequency that the accelerometer
feels, the same unfelt, and a spring (sliding_lines.py, sliding_spring.py; equations in sliding_rows.py). The one of the
largest evidence answers. Where nothing moves, that is the constant. Where none explains the samples, there is no
covariance.

What no method can tell: R(t)^T c for a constant c of the world may be added to any felt r(t), since the centre then
still is at rest. A sensor that sags by c is such a case: only a model of why it moves tells r then. docs/soft-tissue.md
"""

from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array, frozen
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators import sliding_lines, sliding_spring
from imubench.estimators.gravity import How, linear_acceleration
from imubench.estimators.mrvs import gyro_noise, only_imu, why_unidentifiable
from imubench.estimators.sliding_lines import Lines
from imubench.estimators.sliding_rows import Rows
from imubench.estimators.sliding_spring import Spring
from imubench.recording import Imu, Recording

NAME, STREAM = "sliding", "sliding-stream"
KINDS = ("felt", "unfelt", "spring")
WINDOW = 8.0  # s, of the last samples that a stream fits
FIRST = 2.0  # s, before a stream answers
EVERY = 0.5  # s, between two fits of the kind that answers
CONTEST = 4  # fits, between two of all kinds
UNEXPLAINED = 2.0  # times the noise's power in the residuals: no kind of r is right then, nor its covariance
LEAST_NOISE = 1e-6  # rad/s or m/s^2: a record without noise is fitted as if it had this much

Fit = Lines | Spring


def fits(rows: Rows, kinds: tuple[str, ...] = KINDS) -> list[Fit]:
    """Return a fit of each kind, in their order."""
    return [sliding_spring.fit(rows) if kind == "spring" else sliding_lines.fit(rows, kind == "felt") for kind in kinds]


def best(rows: Rows, kinds: tuple[str, ...] = KINDS) -> Fit:
    """Return the fit of the largest evidence."""
    return max(fits(rows, kinds), key=lambda fit: fit.evidence)


def answer(fit: Fit, time: Array) -> tuple[Array, Array]:
    """Return r (n, 3) in m and its covariance (n, 3, 3) at the samples that were fitted."""
    return (fit.values, fit.covariances) if isinstance(fit, Spring) else fit.r(time)


def rows_of(imu: Imu, acceleration: Array) -> Rows:
    """Return the equations of an IMU's record and its acceleration (n, 3) in m/s^2 without gravity."""
    w = imu.gyro_noise_std if imu.gyro_noise_std is not None else gyro_noise(imu.gyro)
    a = imu.accel_noise_std if imu.accel_noise_std is not None else gyro_noise(imu.accel)
    noise = max(w, LEAST_NOISE), max(a, LEAST_NOISE)
    return Rows(imu.time, imu.gyro, imu.accel, imu.accel - acceleration, *noise)


class SlidingStream:
    """One sample in, one r out: the last `WINDOW` fitted again and again, and carried on in between.

    Oscillations are carried on as they are. A spring's d is what the specific force f makes of it,
    m^2 d + 2 z m d' = f, and theta goes by the last rates.
    """

    def __init__(
        self,
        gyro_noise_std: float = 0.0017,
        accel_noise_std: float = 0.02,
        kinds: tuple[str, ...] = KINDS,
        window: float = WINDOW,
    ):
        self.noise = max(gyro_noise_std, LEAST_NOISE), max(accel_noise_std, LEAST_NOISE)
        self.kinds, self.window = kinds, window
        self.fit: Fit | None = None
        self.covariance = np.full((3, 3), np.nan)  # m^2, of the last r
        self._samples: deque[tuple[float, Array, Array, Array]] = deque()
        self._time, self._next, self._count = 0.0, FIRST, 0
        self._offset = np.zeros(3)

    def update(self, gyro: ArrayLike, accel: ArrayLike, acceleration: ArrayLike, dt: float) -> Array:
        """Return r (3,) in m after w (3,) in rad/s, f and, gravity taken out, a (3,) in m/s^2; NaN before `FIRST`.

        `dt` s since the sample before; that of the first is not used.
        """
        w, f, a = (frozen(x, (3,), name) for x, name in ((gyro, "gyro"), (accel, "accel"), (acceleration, "a")))
        if self._samples:
            if not dt > 0:
                raise InputError(f"{STREAM}: expected a time step > 0 s, got {dt!r}")
            self._time += dt
        self._samples.append((self._time, w, f, a))
        while self._time - self._samples[0][0] > self.window:
            self._samples.popleft()
        if self._time >= self._next - 1e-9:
            self._refit()
            self._next = self._time + EVERY
        elif isinstance(self.fit, Spring):
            self._carry(self.fit, f, dt)
        return self._answer()

    def _refit(self) -> None:
        time, w, f, a = (np.array(x) for x in zip(*self._samples, strict=True))
        rows = Rows(time, w, f, f - a, *self.noise)
        if self.fit is None or self._count % CONTEST == 0:
            self.fit = best(rows, self.kinds)
        elif isinstance(self.fit, Spring):
            self.fit = sliding_spring.fit(rows, self.fit.parameters)
        else:
            self.fit = sliding_lines.fit(rows, self.fit.felt)
        self._count += 1
        if isinstance(self.fit, Spring):
            self._offset = self.fit.offset[-1]

    def _carry(self, fit: Spring, f: Array, dt: float) -> None:
        """Take d one step on under f."""
        turn = 2 * np.pi * np.array(fit.frequency)
        stay = np.exp(-dt * turn / (2 * fit.damping))
        self._offset = stay * self._offset + (1 - stay) * f / turn**2

    def _answer(self) -> Array:
        if self.fit is None:
            return np.full(3, np.nan)
        if not isinstance(self.fit, Spring):
            r, covariance = self.fit.r(np.array([self._time]))
            self.covariance = covariance[0]
            return np.asarray(r[0])
        self.covariance = self.fit.covariances[-1]
        before, now = self._samples[-5], self._samples[-1]
        theta = -self.fit.parameters[sliding_spring.SOFT] * (now[1] - before[1]) / (now[0] - before[0])
        r = self.fit.parameters[:3] + self._offset
        return np.asarray(r - np.cross(theta, r))


def estimate(recording: Recording, gravity: How = "ukf", kinds: tuple[str, ...] = KINDS) -> Estimate:
    """Estimate r (n, 1, 3) in m at every sample of a recording with one IMU, from all of it."""
    imu = only_imu(recording, NAME)
    acceleration = linear_acceleration(recording, gravity)
    too_little = why_unidentifiable(imu, acceleration)
    if too_little:  # asked first: fits of next to nothing take longest
        details = {"samples": float(imu.time.size)}
        return Estimate("joint_vector", NAME, np.zeros((1, 3)), None, too_little, "not identifiable", details=details)
    rows = rows_of(imu, acceleration)
    found = fits(rows, kinds)
    fit = max(found, key=lambda one: one.evidence)
    r, covariance = answer(fit, imu.time)
    details = {"samples": float(imu.time.size), "residual_power": fit.noise}
    details |= {f"evidence_{kind}": one.evidence for kind, one in zip(kinds, found, strict=True)}
    if isinstance(fit, Spring):
        details |= {f"spring_frequency_{axis}": f for axis, f in zip("xyz", fit.frequency, strict=True)}
        details["spring_damping"] = fit.damping
    else:
        details |= {f"frequency_{i + 1}": float(f) for i, f in enumerate(fit.frequency)}
    if fit.noise > UNEXPLAINED:
        why = f"no kind of r explains the samples: what is left has {fit.noise:.3g} times the power of the noise"
        return Estimate("joint_vector", NAME, r[:, None], None, why, time=imu.time, details=details)
    return Estimate("joint_vector", NAME, r[:, None], covariance, time=imu.time, details=details)


def estimate_stream(recording: Recording, gravity: How = "ukf", kinds: tuple[str, ...] = KINDS) -> Estimate:
    """Estimate r (n, 1, 3) in m of a recording with one IMU sample by sample, from the past alone."""
    imu = only_imu(recording, STREAM)
    if imu.time[-1] - imu.time[0] < FIRST:
        raise InputError(f"{recording.name}: {STREAM} expected {FIRST:g} s or more, got {np.ptp(imu.time):g} s")
    acceleration = linear_acceleration(recording, gravity)
    rows = rows_of(imu, acceleration)
    stream = SlidingStream(rows.gyro_noise_std, rows.accel_noise_std, kinds)
    r, P = np.empty((imu.time.size, 1, 3)), np.empty((imu.time.size, 3, 3))
    for k, dt in enumerate(np.diff(imu.time, prepend=imu.time[0]).tolist()):
        r[k, 0] = stream.update(imu.gyro[k], imu.accel[k], acceleration[k], dt)
        P[k] = stream.covariance
    seen = np.isfinite(r).all(axis=(1, 2))
    details = {"samples": float(imu.time.size)}
    why = why_unidentifiable(imu, acceleration)
    if why:
        mean = r[seen].mean(axis=0)
        return Estimate("joint_vector", STREAM, mean, None, why, "not identifiable", details=details)
    return Estimate("joint_vector", STREAM, r[seen], P[seen], time=imu.time[seen], details=details)
