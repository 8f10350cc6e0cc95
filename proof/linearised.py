"""What the sensors of a rig read when its motion changes a little: x(t) and its derivatives through S0, S1, S2.

    hinge, free base   x = (dw, df, dq): rate and specific force at the joint in segment 1, and the hinge angle
    hinge, fixed base  x = dq
    pendulum           x = dth, a turn on the right, R exp(dth)
    free body          x = (dth, dp), dp in the world

For a segment with rate w and specific force f, and v = Ry(q)^T w of the hinge's first one (e = +y, Q = Ry(q)):

    turned:  dw = dth' + w x dth,  d(w') = dth'' + w x dth' + w' x dth,  df = f x dth [+ R^T dp'']
    hinged:  dw2 = Q^T dw - dq e x v + e dq',  df2 = Q^T df - dq e x (Q^T f)
"""

from dataclasses import dataclass

import numpy as np

from imubench.proof.frames import Track, read_at
from imubench.proof.played import Case
from imubench.proof.rotation import Array, about, apply_back, skew

E = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Block:
    """Readings (m, k) at `time` with noise `std`, and their sensitivities (m, k, c) to x, x', x''."""

    name: str
    time: Array
    std: float
    S: tuple[Array, Array, Array]


Change = tuple[Array, Array, Array]  # (m, 3, c) each: to x, x', x''


def blocks(case: Case, noise: dict[str, float]) -> list[Block]:
    """Return the readings of every sensor of a case, `noise` by name; poses of a hinge's segments are left out."""
    found = []
    for i, (samples, mount) in enumerate(zip(case.imus, case.mounts, strict=True)):
        gyro, accel = f"imu{i + 1}.gyro", f"imu{i + 1}.accel"
        segment = _at(case.world.segments[i], samples.time)
        w, dw, f = _changes(case, i, samples.time)
        d, Rt = mount.position, mount.rotation.T
        lever = skew(np.cross(segment.w, d)) + skew(segment.w) @ skew(d)
        found.append(Block(gyro, samples.time, noise[gyro], (Rt @ w[0], Rt @ w[1], Rt @ w[2])))
        a, b, c = (Rt @ (f[k] - skew(d) @ dw[k] - lever @ w[k]) for k in range(3))
        found.append(Block(accel, samples.time, noise[accel], (a, b, c)))
    return found


def components(case: Case) -> int:
    """Return how many unknown functions of time a rig's motion has."""
    return 1 if case.options.clamped else case.options.shape.motion


def _at(track: Track, time: Array) -> Track:
    return Track(*(read_at(time, np.ascontiguousarray(x)) for x in (track.p, track.R, track.w, track.dw, track.f)))


def _changes(case: Case, i: int, time: Array) -> tuple[Change, Change, Change]:
    """Return how rate, its derivative and the specific force of segment i change with x."""
    m, c = len(time), components(case)

    def blank() -> Change:
        return np.zeros((m, 3, c)), np.zeros((m, 3, c)), np.zeros((m, 3, c))

    w, dw, f = blank(), blank(), blank()
    segment, one = _at(case.world.segments[i], time), np.eye(3)
    if not case.options.shape.hinge:
        w[0][..., :3], w[1][..., :3] = skew(segment.w), one
        dw[0][..., :3], dw[1][..., :3], dw[2][..., :3] = skew(segment.dw), skew(segment.w), one
        f[0][..., :3] = skew(segment.f)
        if c == 6:
            f[2][..., 3:] = np.swapaxes(segment.R, 1, 2)
        return w, dw, f
    first, fixed = _at(case.world.segments[0], time), case.options.base == "fixed"
    if i == 0:
        if not fixed:
            w[0][..., :3], dw[1][..., :3], f[0][..., 3:6] = one, one, one
        return w, dw, f
    q, q1 = (read_at(time, case.world.angle[k]) for k in (0, 1))
    Q = about(1, q)
    v, v1, g = (apply_back(Q, x) for x in (first.w, first.dw, first.f))
    w[0][..., -1], w[1][..., -1] = -np.cross(E, v), E
    dw[0][..., -1] = -np.cross(E, v1) + q1[:, None] * np.cross(E, np.cross(E, v))
    dw[1][..., -1], dw[2][..., -1] = -np.cross(E, v), E
    f[0][..., -1] = -np.cross(E, g)
    if not fixed:
        Qt = np.swapaxes(Q, 1, 2)
        w[0][..., :3], dw[1][..., :3], f[0][..., 3:6] = Qt, Qt, Qt
        dw[0][..., :3] = -q1[:, None, None] * (skew(E) @ Qt)
    return w, dw, f
