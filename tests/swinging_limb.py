"""A limb that swings about its joint, its sensor sliding or on a spring, in NumPy alone.

Angles are Euler's, and accelerations differences of where the sensor is.
"""

import numpy as np

from imubench.estimators.sliding_rows import Rows

RATE, NOISE = 100.0, (0.0017, 0.02)
R0 = np.array([-0.06, 0.02, 0.2])
G = np.array([0.0, 0.0, 9.81])
FINE = 1e-3  # s, of differences
BIG = ([0.02, 0.005, 0.02], 1.0, 0.3)  # a slide of 3 cm: m, Hz, rad


def turned(t):
    """R (n, 3, 3), limb to world, of the paper's ellipse: Rz Rx Ry."""
    x, y, z = (
        np.deg2rad(d) * np.sin(2 * np.pi * f * t + p) for d, f, p in ((17, 1, 0), (9, 1, np.pi / 2), (3, 2 / 3, 0))
    )
    zero, one = np.zeros_like(t), np.ones_like(t)

    def matrix(*rows):
        return np.stack([np.stack(row, -1) for row in rows], -2)

    rx = matrix((one, zero, zero), (zero, np.cos(x), -np.sin(x)), (zero, np.sin(x), np.cos(x)))
    ry = matrix((np.cos(y), zero, np.sin(y)), (zero, one, zero), (-np.sin(y), zero, np.cos(y)))
    rz = matrix((np.cos(z), -np.sin(z), zero), (np.sin(z), np.cos(z), zero), (zero, zero, one))
    return rz @ rx @ ry


def first_difference(f, t):
    return sum(c * (f(t + k * FINE) - f(t - k * FINE)) for k, c in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))) / FINE


def second_difference(f, t):
    pairs = ((1, 3 / 2), (2, -3 / 20), (3, 1 / 90))
    return (sum(c * (f(t + k * FINE) + f(t - k * FINE)) for k, c in pairs) - 49 / 18 * f(t)) / FINE**2


def rates(t):
    spin = np.swapaxes(turned(t), 1, 2) @ first_difference(turned, t)
    return np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)


def slide(t, *parts):
    """r(t): R0 and, of each part, amplitude (3,) m times sin(2 pi Hz t + phase)."""
    rest = np.broadcast_to(R0, (t.size, 3))
    return rest + sum(np.multiply.outer(np.sin(2 * np.pi * f * t + p), np.asarray(a)) for a, f, p in parts)


def recorded(r, felt=True, seed=None, duration=10.0, noise=NOISE):
    """Rows and true r (n, 3) of a sensor whose vector to the centre is the function r; no seed: no noise."""
    t = np.arange(round(duration * RATE)) / RATE
    R, w = turned(t), rates(t)
    Rt = np.swapaxes(R, 1, 2)

    def place(s):
        return -np.einsum("nij,nj->ni", turned(s), r(s))

    if felt:
        a = np.einsum("nij,nj->ni", Rt, second_difference(place, t))
    else:
        dw = first_difference(rates, t)
        a = -np.cross(dw, r(t)) - np.cross(w, np.cross(w, r(t)))
    if seed is not None:
        rng = np.random.default_rng(seed)
        w, a = w + noise[0] * rng.normal(size=w.shape), a + noise[1] * rng.normal(size=a.shape)
    return Rows(t, w, a + Rt @ G, Rt @ G, *noise), r(t)


def sprung(frequency, damping, seed=None, duration=10.0):
    """The same for a sensor on a spring and damper that pulls alike along all axes; it does not turn on the limb."""
    m, n, h = 2 * np.pi * frequency, round(duration * RATE), 0.25 / RATE
    halves = np.arange(8 * n) * h / 2
    R, dR, ddR = turned(halves), first_difference(turned, halves), second_difference(turned, halves)
    Rt = np.swapaxes(R, 1, 2)
    gravity, turning, carried = Rt @ G, 2 * Rt @ dR, Rt @ ddR

    def slope(k, x):
        inertial = -gravity[k] - carried[k] @ (x[0] - R0) - turning[k] @ x[1]
        return np.stack([x[1], inertial - m**2 * x[0] - 2 * damping * m * x[1]])

    x = np.empty((4 * n, 2, 3))
    x[0] = -gravity[0] / m**2, np.zeros(3)
    for k in range(4 * n - 1):  # Runge and Kutta's, four steps a sample
        k1 = slope(2 * k, x[k])
        k2 = slope(2 * k + 1, x[k] + h / 2 * k1)
        k3 = slope(2 * k + 1, x[k] + h / 2 * k2)
        x[k + 1] = x[k] + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(2 * k + 2, x[k] + h * k3))
    x, t = x[::4], np.arange(n) / RATE
    up = np.swapaxes(turned(t), 1, 2) @ G
    a, w = -(m**2) * x[:, 0] - 2 * damping * m * x[:, 1] - up, rates(t)
    if seed is not None:
        rng = np.random.default_rng(seed)
        w, a = w + NOISE[0] * rng.normal(size=w.shape), a + NOISE[1] * rng.normal(size=a.shape)
    return Rows(t, w, a + up, up, *NOISE), R0 - x[:, 0]
