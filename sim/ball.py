"""Torques on a ball joint for which MuJoCo has no term: dry friction, drag, a spring and a stop across its swing.

With w the limb's rate and R its attitude (limb -> world), q = atan2(R[0, 2], R[2, 2]) its swing, in the limb's axes::

    tau = -(t / sqrt(w.w + STICK^2) + d |w|) w - k (q - q0) a - side max(0, K depth + B rate) G

depth = side (q - angle) > 0, rate = side q'. y = R^T e_y is the world's y, G = (y_x, y_y, 0) / (y_x^2 + y_y^2) the
gradient of q by a rotation, q' = G . w, and a is y or G. Along G a spring and a stop keep their energy; in the plane of
the swing the two are the same, beside it y turns the limb about its own axis, ever faster. MuJoCo's
`frictionloss` and `dampingpoly` of a ball joint act on each axis by itself: about a skew axis that is up to sqrt(3) as
much friction and down to 1 / sqrt(3) as much drag.

A step of h is half a step of the friction alone, I w' = -kappa w with kappa held at its middle, solved exactly; a step
of MuJoCo with the other torques held at the state that is foreseen for its middle; and the other half. Its error is of
order 2.
"""

from copy import copy
from typing import Any

import mujoco
import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.sim.rigs import Rig

STICK = 1e-3  # rad/s, below which dry friction gives way: a limb that rests creeps by less than that


def needs_ball(rig: Rig) -> bool:
    """Return whether a rig has a torque on a ball joint for which MuJoCo has no term."""
    return rig.tree.ball is not None and bool(rig.dry_friction or rig.drag or rig.stiffness or rig.stop is not None)


def resistance(rig: Rig, rate: Array) -> float:
    """Return kappa, N m s/rad, of the torque -kappa w by dry friction and drag at a rate w (3,) rad/s."""
    square = float(rate @ rate)
    return rig.dry_friction / float(np.sqrt(square + STICK**2)) + rig.drag * float(np.sqrt(square))


def across(rig: Rig, quaternion: Array, rate: Array, near: float = 0.0) -> tuple[Array, float]:
    """Return the torque (3,) N m of spring and stop in the limb's axes, and the swing in rad.

    Args:
        rig: a pendulum.
        quaternion: (4,) of the limb, limb -> world.
        rate: (3,) rad/s, of the limb, its own axes.
        near: rad; of the angles q + 2 pi n the swing is the nearest to this.
    """
    R = rotations.to_matrix(quaternion / np.linalg.norm(quaternion))
    q = float(np.arctan2(R[0, 2], R[2, 2]))
    q += 2 * np.pi * round((near - q) / (2 * np.pi))
    up = R[1]
    gradient = np.array([up[0], up[1], 0.0]) / max(float(up[0] ** 2 + up[1] ** 2), 1e-12)
    torque = -rig.stiffness * (q - rig.spring_angle) * (gradient if rig.spring_conserves else up)
    if rig.stop is not None:
        side = rig.stop.side
        depth = side * (q - rig.stop.angle)
        if depth > 0:
            pushed = rig.stop.stiffness * depth + rig.stop.damping * side * float(gradient @ rate)
            torque = torque - side * max(0.0, pushed) * gradient
    return torque, q


def swing_ball(
    rig: Rig, model: Any, start: tuple[Array, Array], samples: int, split: int, control: Array | None = None
) -> Array:
    """Return MuJoCo's sensor data (samples, nsensordata) of a pendulum let go, one sample every `split` steps.

    Args:
        rig: for which `needs_ball` holds.
        model: of it, integrated by Runge and Kutta's rule; it is not changed.
        start: qpos (nq,) and qvel (nv,).
        samples: how many.
        split: steps to a sample.
        control: (steps, nv) N m, applied torques besides.
    """
    model = copy(model)
    assert rig.tree.ball is not None
    joint = model.joint(rig.tree.ball.name)
    ball = slice(int(joint.dofadr[0]), int(joint.dofadr[0]) + 3)
    turn = slice(int(joint.qposadr[0]), int(joint.qposadr[0]) + 4)
    model.dof_frictionloss[ball] = model.dof_dampingpoly[ball] = 0.0
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    rates, axes = np.linalg.eig(np.linalg.inv(mass[ball, ball]))
    back = np.linalg.inv(axes)
    h, swing = float(model.opt.timestep), 0.0
    out = np.empty((samples, model.nsensordata))

    def slowed(rate: Array) -> Array:
        """Return a rate after half a step of friction, by the kappa in the middle of that."""
        own = back @ rate
        middle = axes @ (np.exp(-resistance(rig, rate) * rates * h / 4) * own)
        return np.asarray(axes @ (np.exp(-resistance(rig, middle) * rates * h / 2) * own))

    for step in range((samples - 1) * split + 1):
        given = np.zeros(model.nv) if control is None else control[step]
        if step % split == 0:
            torque, swing = across(rig, data.qpos[turn], data.qvel[ball], swing)
            data.qfrc_applied[:] = given
            data.qfrc_applied[ball] += torque - resistance(rig, data.qvel[ball]) * data.qvel[ball]
            mujoco.mj_forward(model, data)
            out[step // split] = data.sensordata
        data.qvel[ball] = slowed(data.qvel[ball])
        ahead = rotations.multiply(data.qpos[turn], rotations.exp(data.qvel[ball] * h / 2))
        torque, swing = across(rig, ahead, data.qvel[ball], swing)
        data.qfrc_applied[:] = given
        data.qfrc_applied[ball] += torque
        mujoco.mj_step(model, data)
        data.qvel[ball] = slowed(data.qvel[ball])
    return out
