"""What a joint may do beside turning: its frames for segment 2, from those that come before it in the chain.

    moving_centre   segment 2's origin sits at slide * q in segment 1
    axis_coupling   Rx(c1 q) Rz(c2 q) behind Ry(q)
    joint_play      exp(phi e) behind these, e = (cos d, 0, sin d) in segment 2, |phi| < range

The play moves by its own physics, from the limb's inertia and weight (reach m, gyration m):
psi'' = -(e . w') - e . (c x f) / rho^2 - (2 pi f0)^2 psi - 2 z (2 pi f0) psi', phi = range * tanh(psi / range);
f0 is 1.5 Hz for a free play, whose limb then mostly leans on one side, and 6 Hz for a springy one.
"""

import numpy as np
from scipy.signal import cont2discrete, lfilter

from imubench.proof.frames import STEP, Track
from imubench.proof.rotation import Array, Parameters, exp

Angle = tuple[Array, Array, Array]
REACH, GYRATION = np.array([0.15, 0.0, 0.0]), 0.2  # m, of the limb that rattles
PLAY = {"free": (1.5, 0.5), "springy": (6.0, 0.2)}  # Hz and damping ratio


def slid(track: Track, angle: Angle, moving: Parameters | None) -> Track:
    """Return segment 1's frame moved to the origin of segment 2."""
    if moving is None:
        return track
    slide = np.asarray(moving["slide"], dtype=float)
    return track.placed(*(np.outer(a, slide) for a in angle))


def coupled(track: Track, angle: Angle, coupling: Parameters | None) -> Track:
    """Return the frame turned by the off-axis rotation that follows the hinge angle."""
    if coupling is None:
        return track
    for axis, factor in zip((0, 2), coupling["coupling"], strict=True):
        track = track.rotated(axis, *(float(factor) * a for a in angle))
    return track


def played(track: Track, play: Parameters | None) -> Track:
    """Return the frame turned across the hinge axis by the play."""
    if play is None:
        return track
    limit, direction = float(play["range"]), float(play["direction"])
    e = np.array([np.cos(direction), 0.0, np.sin(direction)])
    drive = -track.dw @ e - np.cross(REACH, track.f) @ e / GYRATION**2
    psi, psi1, psi2 = _oscillator(drive, *PLAY[play.get("kind", "free")])
    if play.get("kind", "free") == "springy":  # mostly within the range, so that it acts as a spring
        shrink = 0.8 * limit / (np.std(psi) + 1e-12)
        psi, psi1, psi2 = shrink * psi, shrink * psi1, shrink * psi2
    y = np.tanh(psi / limit)
    phi, slope = limit * y, 1 - y**2
    rate, accel = slope * psi1, slope * psi2 - 2 * y * slope * psi1**2 / limit
    return track.turned(exp(phi[:, None] * e), rate[:, None] * e, accel[:, None] * e)


def _oscillator(drive: Array, frequency: float, damping: float) -> Angle:
    """Return x, x', x'' with x'' + 2 z w x' + w^2 x = drive, from rest; exact for a drive linear between points."""
    w = 2 * np.pi * frequency
    A, B = np.array([[0.0, 1.0], [-(w**2), -2 * damping * w]]), np.array([[0.0], [1.0]])
    C = np.array([[1.0, 0.0], [0.0, 1.0]])
    Ad, Bd, Cd, Dd, _ = cont2discrete((A, B, C, np.zeros((2, 1))), STEP, method="foh")
    poles = np.poly(Ad)
    states = []
    for i in range(2):
        zeros = np.poly(Ad - Bd @ Cd[i : i + 1]) + (Dd[i, 0] - 1) * poles
        states.append(np.asarray(lfilter(zeros, poles, drive - drive[0])))
    x = states[0] + drive[0] / w**2
    return x, states[1], drive - 2 * damping * w * states[1] - w**2 * x
