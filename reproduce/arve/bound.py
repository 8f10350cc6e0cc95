"""What any estimator can know of a sliding r: Cramer-Rao bounds from the motion alone, nothing shared with estimators.

The acceleration is a = -R^T (R r)'', with R of the prescribed motion and differences in time. Unknown are r0 and the
numbers that describe the slide; the orientation is known and the accelerometer's noise white. The gyroscope's is left
out: with it every bound would be higher.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.scenarios.pendulum import DURATION, ellipse

R_STD, LOOSE = 0.5, 10.0  # m: of r0 before any sample; of the rest where nothing is known of it
RATE, NOISE = 100.0, 0.02  # Hz, m/s^2 per sample
FINE = 2e-3  # s, of differences
STENCIL = ((0, -49 / 18), (1, 3 / 2), (2, -3 / 20), (3, 1 / 90))  # of a second derivative, error of sixth order
Path = Callable[[Array], Array]
"""Takes times (n,) in s; returns values (n, columns)."""


def turned(time: Array) -> Array:
    """Return R (n, 3, 3), sensor to world."""
    return rotations.to_matrix(ellipse()(time).quaternion)


def columns(paths: Path, duration: float = DURATION) -> Array:
    """Return what one unit of each path along each axis of r does to a: (3 n, 3 columns)."""
    time = np.arange(round(duration * RATE)) / RATE
    second: Array = np.zeros(())
    for k, weight in STENCIL:
        for sign in (1, -1) if k else (1,):
            at = time + sign * k * FINE
            second = second + weight / FINE**2 * np.einsum("nij,nc->nicj", turned(at), paths(at))
    moved = -np.einsum("nji,njck->nick", turned(time), second)
    return moved.reshape(3 * time.size, -1)


def waves(frequencies: Array) -> Path:
    """Return 1, and sine and cosine of each frequency."""

    def paths(time: Array) -> Array:
        phase = 2 * np.pi * np.multiply.outer(time, frequencies)
        return np.concatenate([np.ones((time.size, 1)), np.sin(phase), np.cos(phase)], axis=1)

    return paths


def bound(X: Array, shapes: Array, prior: float) -> float:
    """Return the least std in m of r(t), root mean square over time, summed over the axes.

    X (3 n, p) are derivatives of a, `shapes` (n, 3, p) those of r; r0 comes first. `prior` in m is the std of the
    slide's numbers before any sample, that of r0 is R_STD.
    """
    std = np.where(np.arange(X.shape[1]) < 3, R_STD, prior)
    scaled = X * std
    information = scaled.T @ scaled / NOISE**2 + np.eye(std.size)
    covariance = std[:, None] * np.linalg.inv(information) * std
    return float(np.sqrt(np.einsum("nip,pq,niq->", shapes, covariance, shapes, optimize=True) / len(shapes)))


def shaped(paths: Path, duration: float = DURATION) -> Array:
    """Return what one unit of each path along each axis does to r: (n, 3, 3 columns)."""
    time = np.arange(round(duration * RATE)) / RATE
    return np.einsum("nc,ik->nick", paths(time), np.eye(3)).reshape(time.size, 3, -1)


def _sine(frequency: float, phase: float, time: Array) -> Array:
    return np.sin(2 * np.pi * frequency * time + phase)[:, None]


def known(frequency: float, duration: float = DURATION) -> float:
    """Return the bound in m with one slide of known frequency."""
    paths = waves(np.array([frequency]))
    return bound(columns(paths, duration), shaped(paths, duration), LOOSE)


def sought(frequency: float, amplitude: Array, phase: float = 0.0, duration: float = DURATION) -> float:
    """Return the bound in m with one slide of unknown frequency, amplitude (3,) m."""
    h = 1e-4
    paths = waves(np.array([frequency]))

    def by(make: Callable[[Path, float], Array]) -> Array:
        up, down = (make(partial(_sine, frequency + s * h, phase), duration) for s in (1, -1))
        change = (up - down) @ amplitude / (2 * h)
        return np.concatenate([make(paths, duration), change[..., None]], axis=-1)

    return bound(by(columns), by(shaped), LOOSE)


def free(highest: float, prior: float, duration: float = DURATION) -> float:
    """Return the bound in m with a slide of waves up to `highest` Hz, as many as a record tells apart."""
    paths = waves(np.arange(1, round(duration * highest) + 1) / duration)
    return bound(columns(paths, duration), shaped(paths, duration), prior)


def only() -> float:
    """Return the bound in m of an r that is constant."""
    paths = waves(np.zeros(0))
    return bound(columns(paths), shaped(paths), LOOSE)
