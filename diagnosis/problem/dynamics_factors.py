"""The equation of motion of the swinging segment inside free swings, where no outside force acts.

About the joint, in segment axes, f the specific force at the joint, which holds gravity and the joint's
own acceleration: I w' + w x (I w) + m c x f = torque. A hinge carries every component but that about its
axis; a ball joint none.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from imubench.arrays import Array
from imubench.diagnosis.config.solve import SWING
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.residuals import SWING_EQUATION, Rows
from imubench.diagnosis.problem.rig_kinematics import HINGE_AXIS
from imubench.jets import Jet, cross
from imubench.recording import STANDARD_GRAVITY, Body


def inertia_about_joint(body: Body) -> Array:
    """Return the inertia (3, 3) kg m^2 about the segment's origin."""
    c = body.com
    return np.asarray(np.diag(body.inertia) + body.mass * (c @ c * np.eye(3) - np.outer(c, c)), dtype=float)


def resting(model: Model, time: Array) -> NDArray[np.bool_]:
    """Return at which of the times (n,) the segment is at rest: friction may hold it where no law says."""
    imu = model.recording.imus[-1]
    rate = uniform_filter1d(np.linalg.norm(imu.gyro, axis=1), max(int(SWING.rest_s * imu.rate), 1))
    return np.asarray(np.interp(time, imu.time - model.start, rate) < SWING.still_rad_s, dtype=bool)


def turning(model: Model, body: Body, time: Array) -> NDArray[np.bool_]:
    """Return at which of the times (n,) the segment turns round, swinging: dry friction jumps there, a spline cannot.

    With the equation asked there, the motion rang about every jump by 0.13 of the friction, which looked like a torque
    of the joint's rate. Where a stop turns it round, quicker than gravity can, the equation stays.
    """
    reach = SWING.jump_knots * model.tracks.knots.step
    before, after = (whirl(model, time + shift) for shift in (-reach, reach))
    weight = body.mass * STANDARD_GRAVITY * float(np.linalg.norm(body.com))
    gravity = weight / float(np.linalg.norm(inertia_about_joint(body), 2))
    gentle = np.linalg.norm(after - before, axis=1) < SWING.hard_factor * gravity * 2 * reach
    return np.asarray((np.sum(before * after, axis=1) < 0) & gentle, dtype=bool)


def whirl(model: Model, time: Array) -> Array:
    """Return how fast the swinging segment turns at times (n,): (n, 3) or (n, 1) rad/s, as its sensor says, or 0."""
    recording, over = model.recording, model.tracks.knots.step
    if recording.imus:
        imu = recording.imus[-1]
        gyro = uniform_filter1d(imu.gyro, 2 * int(over * imu.rate / 2) + 1, axis=0)  # odd: not late
        return np.stack([np.interp(time, imu.time - model.start, x) for x in gyro.T], axis=1)
    if not recording.encoders:
        return np.zeros((len(time), 1))
    encoder = recording.encoders[0]
    ahead, behind = (np.interp(time + d, encoder.time - model.start, encoder.angle) for d in (over / 2, -over / 2))
    return np.asarray((ahead - behind)[:, None] / over, dtype=float)


def swing_rows(model: Model, state: State, time: Array) -> Iterator[Rows]:
    """Yield the equation's residual (n, 1 or 3) N m at those of the times (n,) that lie in a free swing."""
    body = model.recording.body
    inside = np.zeros(len(time), dtype=bool)
    reach = SWING.jump_knots * model.tracks.knots.step
    for start, end in model.recording.free_swings:
        inside |= (time >= start - model.start + reach) & (time <= end - model.start - reach)
    if body is None or not inside.any():
        return
    inside &= ~turning(model, body, time)
    if model.recording.imus:
        inside &= ~resting(model, time)
    if not inside.any():
        return
    time = time[inside]
    residual = missing_torque(model, state, body, time)
    if model.rig.hinge:
        residual = residual[[HINGE_AXIS]]
    std = SWING.equation_std * body.mass * STANDARD_GRAVITY * max(float(np.linalg.norm(body.com)), 0.01)
    yield Rows(SWING_EQUATION, time, residual, np.full(residual.value.shape[1], std), counts=False)


def missing_torque(model: Model, state: State, body: Body, time: Array) -> Jet:
    """Return what the equation lacks at times (n,) s of the splines: (n, 3) N m about the joint, in segment axes."""
    moment = Moment(model.tracks, state.coefficients, Jet(time[:, None]))
    segment = model.last(state, moment)
    inertia = inertia_about_joint(body)
    inert = segment.accel.at(inertia) + cross(segment.rate, segment.rate.at(inertia))
    torque = cross(segment.force, body.mass * body.com)
    scene = model.scene(moment, segment)
    for h in model.at("joint"):
        added = h.effect.torque(model.own(scene, h, moment), model.values(h, state))
        if added is not None:
            torque = torque + added
    for h in model.at("body"):
        if (factor := h.effect.lighter(model.values(h, state))) is not None:
            torque = (
                torque * factor
            )  # and not what is seen of the acceleration divided: the residual could shrink to zero
    return inert - torque
