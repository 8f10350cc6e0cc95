"""Free swings integrated forward on the fine grid: one degree of freedom, and a rigid body on a ball joint.

Runge and Kutta's fourth-order rule in plain floats; a grid step is 1 ms, so that swings of about 1 Hz are exact to
1e-9 and a stop that bounces at 25 Hz to 1e-4. Dry friction near rest is stiff about the limb's own axis: there the
steps are cut.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, ceil, sqrt

import numpy as np

from imubench.proof.frames import STEP
from imubench.proof.motion import smooth_step
from imubench.proof.rotation import Array
from imubench.proof.torques import STICK, Torques

LIFT, HOLD = 1.5, 0.4  # s in which a hand lifts, then holds
SLOW = 0.2  # rad/s, under which dry friction is so steep that grid steps are cut
STABLE = 1.0  # of a step times the steepest rate; the rule is unstable from 2.8
RELEASE = 0.06  # s in which it lets go: the acceleration fades in


@dataclass(frozen=True)
class Phase:
    """One lift, hold and free swing, as grid points."""

    lift: int
    hold: int
    release: int
    end: int
    window: tuple[float, float]  # s, what the recording declares: within the free part


def plan(rng: np.random.Generator, t: Array, seconds: float) -> list[Phase]:
    """Return the phases of a recording: a swing for about every 35 s."""
    count = max(1, round(seconds / 35))
    each = seconds / count
    releases = [each * k + min(rng.uniform(0.5, 3.0), 0.2 * each) for k in range(count)]
    points = [int(np.searchsorted(t, r)) for r in releases]
    lifts = [p - round((LIFT + HOLD) / STEP) for p in points]
    ends = [*lifts[1:], len(t) - 1]
    phases = []
    for lift, release, end in zip(lifts, points, ends, strict=True):
        start = float(t[release]) + rng.uniform(0.08, 0.3)
        window = (round(start, 3), round(min(float(t[end]) - 0.05, seconds), 3))
        phases.append(Phase(max(lift, 0), lift + round(LIFT / STEP), release, end, window))
    return phases


def joined(x0: float, v0: float, a0: float, x1: float, v1: float, points: int) -> tuple[Array, Array, Array]:
    """Return x, x', x'' (points,) on the quintic from x0, v0, a0 to x1, v1 without acceleration."""
    T = STEP * (points - 1)
    s = np.linspace(0.0, 1.0, points)
    c = [x0, v0 * T, a0 * T**2 / 2]
    x, v, a = x1 - sum(c), v1 * T - c[1] - 2 * c[2], -2 * c[2]
    c += [10 * x - 4 * v + a / 2, -15 * x + 7 * v - a, 6 * x - 3 * v + a / 2]
    p = np.polynomial.Polynomial(c)
    return p(s), p.deriv()(s) / T, p.deriv(2)(s) / T**2


def fade(points: int) -> list[float]:
    """Return how far the hand has let go at every half grid step after its release."""
    return [float(x) for x in smooth_step(np.asarray(STEP / 2 * np.arange(2 * points + 2) / RELEASE, dtype=float))[1]]


def swing_hinge(
    q: Array,
    w: Array,
    a: Array,
    first: int,
    last: int,
    accel: Callable[[float, float, float], float],
    wind: Array,
    released: bool = True,
) -> None:
    """Fill in q, w, a from grid point `first` to `last`; accel(angle, rate, wind) rad/s^2.

    `released`: a hand lets go at `first`; False: it is swinging freely there.
    """
    free, gust = let_go(last - first, released), [float(x) for x in wind[first : last + 1]]
    x, v, h = float(q[first]), float(w[first]), STEP
    for i in range(last - first):
        here, there, middle, now = gust[i], gust[i + 1], free[2 * i + 1], free[2 * i]
        mean = (here + there) / 2
        a1 = now * accel(x, v, here)
        v2 = v + h / 2 * a1
        a2 = middle * accel(x + h / 2 * v, v2, mean)
        v3 = v + h / 2 * a2
        a3 = middle * accel(x + h / 2 * v2, v3, mean)
        v4 = v + h * a3
        a4 = free[2 * i + 2] * accel(x + h * v3, v4, there)
        k = first + i
        q[k], w[k], a[k] = x, v, a1
        x, v = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    q[last], w[last], a[last] = x, v, accel(x, v, gust[-1])


def let_go(points: int, released: bool) -> list[float]:
    """Return how far the hand has let go at every half grid step: it does so now, or has done so before."""
    return fade(points) if released else [1.0] * (2 * points + 2)


@dataclass(frozen=True)
class Ball:
    """A rigid body on a ball joint: I w' + w x I w = m c x R^T (g - a_pivot) + (resistance) w + T(q) dq/dphi.

    A torque T(q) that depends on the swing q = atan2(z_x, z_z), z the limb's axis, acts on that coordinate: its vector
    is T times the gradient of q by a rotation, (e_y - z_y z) / (1 - z_y^2) in the world. That is about world y for a
    limb in the plane of the swing, and never turns the limb about its own axis, so that a spring keeps its energy.
    """

    moment: tuple[float, float, float]  # kg m, m c in segment axes
    inertia: Array  # (3, 3) kg m^2 about the pivot, segment axes, already over `scale`
    gravity: float
    torques: Torques

    def substeps(self) -> int:
        """Return the parts of a grid step that dry friction near rest needs about the axis of least inertia."""
        return max(1, ceil(self.torques.t / STICK / float(np.linalg.eigvalsh(self.inertia)[0]) * STEP / STABLE))

    def rate(self) -> Callable[..., list[float]]:
        """Return the derivative of (q, w) at a state (7,), pivot acceleration (3,) and wind."""
        (mx, my, mz), law, g = self.moment, self.torques, self.gravity
        (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = self.inertia.tolist()
        (jxx, jxy, jxz), (_, jyy, jyz), (_, _, jzz) = np.linalg.inv(self.inertia).tolist()
        about_y = bool(law.k or law.stop_k or law.cogging or np.any(law.wind))

        def derivative(s: list[float], pivot: tuple[float, float, float], wind: float) -> list[float]:
            e, x, y, z, p, q, r = s
            ax, ay, az = -pivot[0], -pivot[1], -g - pivot[2]
            r00, r01, r02 = 1 - 2 * (y * y + z * z), 2 * (x * y - e * z), 2 * (x * z + e * y)
            r10, r11, r12 = 2 * (x * y + e * z), 1 - 2 * (x * x + z * z), 2 * (y * z - e * x)
            r20, r21, r22 = 2 * (x * z - e * y), 2 * (y * z + e * x), 1 - 2 * (x * x + y * y)
            gx, gy, gz = r00 * ax + r10 * ay + r20 * az, r01 * ax + r11 * ay + r21 * az, r02 * ax + r12 * ay + r22 * az
            k = law.along(sqrt(p * p + q * q + r * r))
            hx, hy, hz = ixx * p + ixy * q + ixz * r, ixy * p + iyy * q + iyz * r, ixz * p + iyz * q + izz * r
            tx = my * gz - mz * gy - q * hz + r * hy + k * p
            ty = mz * gx - mx * gz - r * hx + p * hz + k * q
            tz = mx * gy - my * gx - p * hy + q * hx + k * r
            if about_y:
                d02, d22 = r00 * q - r01 * p, r20 * q - r21 * p  # R [w]x, third column
                square = r02 * r02 + r22 * r22
                torque = (law.about(atan2(r02, r22), (d02 * r22 - d22 * r02) / square) + wind) / square
                tx, ty = tx + r10 * torque, ty + r11 * torque  # the gradient of the swing has no axial part
            return [
                (-x * p - y * q - z * r) / 2, (e * p + y * r - z * q) / 2,
                (e * q + z * p - x * r) / 2, (e * r + x * q - y * p) / 2,
                jxx * tx + jxy * ty + jxz * tz, jxy * tx + jyy * ty + jyz * tz, jxz * tx + jyz * ty + jzz * tz,
            ]  # fmt: skip

        return derivative


def swing_ball(ball: Ball, state: list[float], pivot: Array, wind: Array, released: bool = True) -> tuple[Array, Array]:
    """Return states (n, 7), quaternion and rate in segment axes, and their w' (n, 3), from a `state` (7,) on.

    pivot (n, 3) m/s^2 in the world and wind (n,) N m about world y, at the n grid points of the swing. `released`: a
    hand lets go at the first one; False: it is swinging freely there.
    """
    rate, n, h = ball.rate(), len(pivot), STEP
    free, base, gust = let_go(n, released), [tuple(row) for row in pivot.tolist()], wind.tolist()
    states, accel = np.empty((n, 7)), np.empty((n, 3))

    def slope(s: list[float], here: tuple[float, float, float], blow: float, share: float) -> list[float]:
        d = rate(s, here, blow)
        return d if share == 1.0 else [*d[:4], share * d[4], share * d[5], share * d[6]]

    def step(s: list[float], part: float, at: tuple[float, float]) -> list[float]:
        """Return the state after a part of a grid step, from and to a share of grid step i."""
        ends = [at[0], (at[0] + at[1]) / 2, at[1]] if part < h else [0.0, 0.5, 1.0]
        bases = [_between(base[i], base[i + 1], x) for x in ends]
        blows = [gust[i] + (gust[i + 1] - gust[i]) * x for x in ends]
        shares = [_at(free, 2 * (i + x)) for x in ends]
        k1 = slope(s, bases[0], blows[0], shares[0])
        k2 = slope([x + part / 2 * k for x, k in zip(s, k1, strict=True)], bases[1], blows[1], shares[1])
        k3 = slope([x + part / 2 * k for x, k in zip(s, k2, strict=True)], bases[1], blows[1], shares[1])
        k4 = slope([x + part * k for x, k in zip(s, k3, strict=True)], bases[2], blows[2], shares[2])
        s = [x + part / 6 * (p + 2 * q + 2 * r + u) for x, p, q, r, u in zip(s, k1, k2, k3, k4, strict=True)]
        norm = sqrt(s[0] ** 2 + s[1] ** 2 + s[2] ** 2 + s[3] ** 2)
        return [*(x / norm for x in s[:4]), *s[4:]]

    fine, s = ball.substeps(), state
    for i in range(n):
        states[i], accel[i] = s, slope(s, base[i], gust[i], free[2 * i])[4:]
        if i < n - 1:
            parts = fine if sqrt(s[4] ** 2 + s[5] ** 2 + s[6] ** 2) < SLOW else 1
            for j in range(parts):
                s = step(s, h / parts, (j / parts, (j + 1) / parts))
    return states, accel


def _between(a: tuple[float, ...], b: tuple[float, ...], share: float) -> tuple[float, float, float]:
    return (a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share, a[2] + (b[2] - a[2]) * share)


def _at(values: list[float], place: float) -> float:
    """Return what stands at a place between two values."""
    low = int(place)
    return values[low] + (values[low + 1] - values[low]) * (place - low) if place > low else values[low]
