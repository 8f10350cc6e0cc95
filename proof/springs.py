"""IMUs on springs and dampers, a real mass each, integrated together with the motion that shakes them.

soft_mount: x (segment axes) is the mass's displacement from its unloaded place, where the segment's angular rate is w
and the specific force f. What the springs give is what the mass feels:

    x'' + 2 w x x' + w' x x + w x (w x x) + f = -K x - C x',   K = diag((2 pi f_i)^2), C = diag(2 z 2 pi f_i)

At rest it sags by g / (2 pi f)^2.

rocking_mount: a body of isotropic inertia m rho^2 about its pivot turns by exp(th) (th in nominal sensor axes); with
the nominal frame's rate w, w' and the specific force f at the pivot, and Q = exp(th), its own relative rate u obeys

    u' = -K th - C u - Q^T w' + u x (Q^T w) - com x (Q^T f) / rho^2,      th' = Jr(th)^-1 u

The sensing point sits at `lever` from the pivot and turns with the body.
"""

import numpy as np

from imubench.proof.frames import STEP, Track
from imubench.proof.linear import solve
from imubench.proof.rotation import Array, Parameters, apply, apply_back, exp, skew

ROUNDS = 4  # of the second-order terms of the rocking; each gains a factor of the angle


def _springs(parameters: Parameters) -> tuple[Array, Array]:
    """Return K and C, (3,) each."""
    rate = 2 * np.pi * np.broadcast_to(np.asarray(parameters["frequency"], dtype=float), 3)
    damping = np.broadcast_to(np.asarray(parameters["damping_ratio"], dtype=float), 3)
    return rate**2, 2 * damping * rate


def soft(track: Track, parameters: Parameters) -> Track:
    """Return the frame of a mass on springs whose unloaded place is `track`, in axes of the segment."""
    K, C = _springs(parameters)
    n = len(track.w)
    W = skew(track.w)
    A = np.zeros((n, 6, 6))
    A[:, :3, 3:] = np.eye(3)
    A[:, 3:, :3] = -np.diag(K) - skew(track.dw) - W @ W
    A[:, 3:, 3:] = -np.diag(C) - 2 * W
    b = np.concatenate([np.zeros((n, 3)), -track.f], axis=1)
    x = solve(A, b, np.linalg.solve(A[0], -b[0]), STEP)
    accel = apply(A, x) + b
    return track.placed(x[:, :3], x[:, 3:], accel[:, 3:])


def rocking(track: Track, parameters: Parameters) -> Track:
    """Return the frame of the sensing point, `track` being the nominal one."""
    lever = np.asarray(parameters.get("lever", np.zeros(3)), dtype=float)
    com = np.asarray(parameters.get("com", np.zeros(3)), dtype=float)
    pull = skew(com) / float(parameters.get("gyration", 0.015)) ** 2
    K, C = _springs(parameters)
    pivot = track.placed(-lever)
    n = len(pivot.w)
    # to first order in th: Q^T v = v - th x v = v + [v]x th
    A = np.zeros((n, 6, 6))
    A[:, :3, 3:] = np.eye(3)
    A[:, 3:, :3] = -np.diag(K) - skew(pivot.dw) - pull @ skew(pivot.f)
    A[:, 3:, 3:] = -np.diag(C) - skew(pivot.w)
    b = np.concatenate([np.zeros((n, 3)), -pivot.dw - apply(pull, pivot.f)], axis=1)
    rest = np.zeros((n, 6))
    start = np.linalg.solve(A[0], -b[0])
    for _ in range(ROUNDS):
        x = solve(A, b + rest, start, STEP)
        rest = _exact(pivot, K, C, pull, x) - apply(A, x) - b
    th, u = x[:, :3], x[:, 3:]
    slope = _exact(pivot, K, C, pull, x)
    return pivot.turned(exp(th), u, slope[:, 3:]).placed(lever)


def _exact(pivot: Track, K: Array, C: Array, pull: Array, x: Array) -> Array:
    """Return the whole derivative (n, 6) of (th, u)."""
    th, u = x[:, :3], x[:, 3:]
    Q = exp(th)
    accel = -K * th - C * u - apply_back(Q, pivot.dw) - apply(pull, apply_back(Q, pivot.f))
    accel += np.cross(u, apply_back(Q, pivot.w))
    return np.concatenate([apply(inverse_right_jacobian(th), u), accel], axis=1)


def inverse_right_jacobian(th: Array) -> Array:
    """Return Jr^-1 (n, 3, 3), th' = Jr^-1 u for R = exp(th), R' = R [u]x; to fourth order in th."""
    S = skew(th)
    square = S @ S
    return np.eye(3) + S / 2 + square / 12 - square @ square / 720
