"""A free swing that goes on by other forces: as the declared model would swing, let go where the true limb was."""

from dataclasses import replace

import numpy as np

from imubench.proof.body import limb
from imubench.proof.hinge import clamped, equation, hinged
from imubench.proof.options import Effect, Options, World, find, stream
from imubench.proof.pendulum import carried, hung, pivoted, swing_of
from imubench.proof.rotation import from_quaternion, to_quaternion
from imubench.proof.swing import swing_ball, swing_hinge
from imubench.proof.torques import torques

Windows = list[tuple[float, float]]
"""Stretches of free swings, s; in each the limb is let go where it truly was at the start."""


def resumed(world: World, options: Options, effects: list[Effect], seed: int, windows: Windows) -> World:
    """Return a world whose limb swings by these effects alone inside some windows, and moves as before elsewhere.

    Args:
        world: of a swinging rig, with all that is concealed in it.
        options: of its case.
        effects: that are left.
        seed: of its case.
        windows: within the declared free swings.
    """
    found = find(effects, "gravity")
    gravity = float(found["g"]) if found else options.gravity
    rows = [tuple(int(i) for i in np.searchsorted(world.t, window)) for window in windows]
    turn = _hinge if options.shape.hinge else _ball
    return turn(world, effects, gravity, seed, [(i, min(j, len(world.t) - 1)) for i, j in rows])


def _hinge(world: World, effects: list[Effect], gravity: float, seed: int, rows: list[tuple[int, int]]) -> World:
    first, R = clamped(stream(seed, "motion"), len(world.t), gravity)
    body = limb(stream(seed, "body"), axis=0)
    law = torques(effects, body.about_y, world.t, stream(seed, "wind"))
    accel = equation(law, body, R.T @ np.array([0.0, 0.0, -gravity]))
    q, w, a = (np.array(x) for x in world.angle)
    for i, j in rows:
        q[i], w[i] = world.angle[0][i], world.angle[1][i]
        swing_hinge(q, w, a, i, j, accel, law.wind, released=False)
    return replace(world, segments=[first, hinged(first, (q, w, a), effects)], angle=(q, w, a))


def _ball(world: World, effects: list[Effect], gravity: float, seed: int, rows: list[tuple[int, int]]) -> World:
    pivot = pivoted(effects, world.t, seed)
    ball = hung(limb(stream(seed, "body"), axis=2), effects, world.t, gravity, seed)
    true = world.segments[0]
    R, w, dw = (np.array(x) for x in (true.R, true.w, true.dw))
    for i, j in rows:
        state = [*to_quaternion(true.R[i]).tolist(), *true.w[i].tolist()]
        part = slice(i, j + 1)
        states, dw[part] = swing_ball(ball, state, pivot[1][part], ball.torques.wind[part], released=False)
        R[part], w[part] = from_quaternion(states[:, :4]), states[:, 4:]
    track = carried(pivot, R, w, dw, gravity)
    return replace(world, segments=[track], angle=swing_of(track))


__all__ = ["Windows", "resumed"]
