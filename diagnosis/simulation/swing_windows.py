"""Which stretches of the declared free swings are rolled out: those in which no hand holds the body.

A window may be declared a little early, with the body still held, or long enough for a hand to catch it. A body rests
by itself only where friction can hold it: where what the equation of motion lacks, M(t), is below the dry friction that
was found and a share of the segment's weight, for which the attitude is not known better. A body that rests where that
is not so is held, whatever the residuals say; it swings again from where it moves by more than
`SWING_WINDOW.moving_rad_s`. And what brought it to rest was a hand, over `SWING_WINDOW.catch_s` before.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from imubench.arrays import Array
from imubench.diagnosis.config.simulation import ROLL_OUT, SWING_WINDOW
from imubench.diagnosis.config.solve import SWING
from imubench.diagnosis.problem.dynamics_factors import missing_torque, whirl
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.rig_kinematics import HINGE_AXIS
from imubench.diagnosis.simulation.sim_model import named
from imubench.diagnosis.windows import Window, cut_out
from imubench.recording import STANDARD_GRAVITY


def free(fit: Fit, friction: float | None = None) -> tuple[Window, ...]:
    """Return the stretches of a fit's free swings in which the body is not held, in s of the recording's clock.

    `friction` is the dry friction in N m that may hold it; None: the fit's own.
    """
    recording = fit.model.recording
    if friction is None:
        holding = [h for h in named(fit) if h.effect.holds_by]
        friction = sum(float(fit.model.values(h, fit.state)[h.effect.holds_by].value[0, 0]) for h in holding)
    out = [piece for swing in recording.free_swings for piece in cut_out([swing], held(fit, swing, friction))]
    return tuple(piece for piece in out if piece[1] - piece[0] >= ROLL_OUT.least_s)


def held(fit: Fit, swing: Window, friction: float) -> tuple[Window, ...]:
    """Return when a hand holds the body in a free swing, until it moves again, in s of the recording's clock."""
    model, body = fit.model, fit.model.recording.body
    if body is None:
        return ()
    time = np.arange(swing[0], swing[1], SWING_WINDOW.grid_s) - model.start
    speed = np.linalg.norm(whirl(model, time), axis=1)
    still = uniform_filter1d(speed, max(int(SWING.rest_s / SWING_WINDOW.grid_s), 1), mode="nearest") < SWING.still_rad_s
    if not still.any():
        return ()
    lacks = missing_torque(model, fit.state, body, time).value
    size = np.abs(lacks[:, HINGE_AXIS]) if model.rig.hinge else np.linalg.norm(lacks, axis=1)
    weight = body.mass * STANDARD_GRAVITY * float(np.linalg.norm(body.com))
    return tuple(
        (a + model.start - SWING_WINDOW.catch_s, b + model.start)
        for a, b in stretches(time, still & (size > friction + SWING_WINDOW.level * weight), speed)
    )


def stretches(time: Array, holds: NDArray[np.bool_], speed: Array) -> list[Window]:
    """Return the stretches of time (n,) in which a hand `holds` (n,), each to where the `speed` (n,) is a swing's."""
    out: list[Window] = []
    for k in np.flatnonzero(holds & ~np.concatenate([[False], holds[:-1]])):
        if out and time[k] < out[-1][1]:
            continue
        last = k + int(np.argmin(np.append(holds[k:], False)))
        quick = np.flatnonzero(speed[last:] > SWING_WINDOW.moving_rad_s)
        out.append((float(time[k]), float(time[last + quick[0]] if quick.size else time[-1])))
    return out


__all__ = ["free", "held"]
