"""Whether an IMU's gyroscope and accelerometer have the same axes, told from both without any model of the motion.

Turned into axes that stand still, the specific force is a - g: gravity, which is constant, and the acceleration of a
thing that stays in a room. Its integral less a straight line is that thing's velocity, a metre per second or so, less
on a pivot once the lever arm to it is free. A gyroscope with a wrong sign or with its axes in another order turns
gravity about, and its integral grows to several times that. So of the 48 ways in which a gyroscope's axes can lie
along the accelerometer's (24 orders and signs, and the same mirrored) the true one leaves least.

Free beside it are the lever arm to a point at rest, as sensors move more slowly than limbs' ends do (3 numbers), and
the gyroscope's bias (3): a turn by a slowly growing angle that gravity shows. Both are linear here, and they are what
a pendulum and a hinge on a fixed base would need most.
"""

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from scipy.stats import f as fisher

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.nonsense import AXIS_ORDER
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.config.solve import MOTION_PRIOR
from imubench.diagnosis.nonsense.stretch import Samples
from imubench.diagnosis.solve.initialize import integrated


def signed_permutations() -> tuple[Array, ...]:
    """Return the 48 matrices that change the order and the signs of three axes, those that change least first."""
    out = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        matrix = np.zeros((3, 3))
        matrix[range(3), order] = signs
        out.append(matrix)
    # the sort is stable: equal traces stay in the order that is written here
    return tuple(sorted(out, key=lambda m: (-np.abs(np.diag(m)).sum(), -np.trace(m))))


SIGNED_PERMUTATIONS = signed_permutations()


@dataclass(frozen=True)
class Handedness:
    """How well each way of the gyroscope's axes along the accelerometer's explains one IMU."""

    velocity: Array  # (48,) m/s RMS that is left, of `SIGNED_PERMUTATIONS`
    count: float  # independent numbers that each is made of

    @property
    def best(self) -> int:
        """The way that leaves least; of those within a tenth of it the one that changes least."""
        near = np.flatnonzero(self.velocity <= 1.1 * self.velocity.min())
        return int(near[0])

    @property
    def ratio(self) -> float:
        """What is left with the axes as they are over what the best way leaves."""
        return float(self.velocity[0] / self.velocity[self.best])

    @property
    def wrong(self) -> bool:
        """Return whether the axes as they are can be ruled out.

        By an F test of the two residual powers, and by far more than a model as rough as this may be wrong.
        """
        chance = float(
            fisher.isf(STATISTICS.false_alarms_per_recording / (len(SIGNED_PERMUTATIONS) - 1), self.count, self.count)
        )
        return self.velocity[0] > AXIS_ORDER.least_m_s and self.ratio > max(AXIS_ORDER.worse, float(np.sqrt(chance)))


def handedness(samples: Samples) -> Handedness | None:
    """Return how well each way explains an IMU's samples; none where they are too few seconds."""
    if len(samples.time) * samples.step < EVIDENCE.least_s:
        return None
    left = [_left(samples.gyro @ way.T, samples.accel, samples.step) for way in SIGNED_PERMUTATIONS]
    velocity = np.array([float(np.sqrt(np.mean(np.sum(e**2, axis=2)))) for e in left])
    best = left[int(np.argmin(velocity))]
    return Handedness(np.maximum(velocity, 1e-12), independent(best))


def _left(gyro: Array, accel: Array, step: float) -> Array:
    """Return the velocities (windows, n, 3) m/s that no lever arm and no bias explains; readings are (n, 3)."""
    turn = rotations.to_matrix(integrated(gyro, step))
    force = np.einsum("nij,nj->ni", turn, accel)
    swept = np.cross(gyro[:, None], np.eye(3)[None]).transpose(0, 2, 1)  # w x e_k as columns
    lever = MOTION_PRIOR.unknown_position_m * (turn @ swept)
    angle = np.cumsum(turn, axis=0) * step
    width = min(round(AXIS_ORDER.window_s / step), len(gyro))
    begins = range(0, len(gyro) - width + 1, max(width // 2, 1))
    line, _ = np.linalg.qr(np.vander(np.linspace(-1, 1, width), 2))
    columns, out = [], []
    for begin in begins:
        some = slice(begin, begin + width)
        tilted = np.cross((angle[some] - angle[begin]).transpose(0, 2, 1), force[some, None]).transpose(0, 2, 1)
        bias = AXIS_ORDER.bias_rad_s * step * np.cumsum(tilted, axis=0)
        both = np.concatenate([lever[some], bias], axis=2).reshape(width, -1)
        velocity = step * np.cumsum(force[some], axis=0)
        columns.append((both - line @ (line.T @ both)).reshape(width * 3, -1))
        out.append(velocity - line @ (line.T @ velocity))
    every, seen = np.concatenate(columns), np.concatenate(out).reshape(-1)
    sizes = np.linalg.solve(every.T @ every + np.eye(every.shape[1]), every.T @ seen)
    return np.asarray((seen - every @ sizes).reshape(len(out), width, 3))


def independent(residual: Array) -> float:
    """Return how many independent numbers residuals (windows, n, 3) are worth: windows overlap by half, and they last.

    Of a series whose autocorrelation is c(k) a sum of squares is worth n / sum c(k)^2 of white noise's.
    """
    windows, n, _ = residual.shape
    spectrum = np.sum(np.abs(np.fft.rfft(residual, 2 * n, axis=1)) ** 2, axis=(0, 2))
    correlation = np.fft.irfft(spectrum)[:n]
    lasting = 2 * float(np.sum((correlation / correlation[0]) ** 2)) - 1 if correlation[0] > 0 else float(n)
    return max(3 * n * (windows + 1) / 2 / lasting, 3.0)


__all__ = ["SIGNED_PERMUTATIONS", "Handedness", "handedness"]
