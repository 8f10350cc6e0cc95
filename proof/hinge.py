"""The hinge: two segments, frames in the joint centre, +y the axis; moved by hand, or segment 2 swinging free.

    R2 = R1 Ry(q) [Rx(c1 q) Rz(c2 q)] [exp(play)],  origin of segment 2 at [slide q] in segment 1

In brackets: axis_coupling, joint_play, moving_centre. The base is free (a hand moves it) or fixed.
"""

from collections.abc import Callable
from math import atan2, cos, pi, sin

import numpy as np

from imubench.proof.body import Body, limb
from imubench.proof.frames import Track, in_world
from imubench.proof.joint import coupled, played, slid
from imubench.proof.motion import Tempo, angle_wave, place_wave, random_tempo
from imubench.proof.options import Effect, Options, World, find, stream
from imubench.proof.rotation import Array, about, to_quaternion
from imubench.proof.swing import joined, plan, swing_hinge
from imubench.proof.torques import Torques, torques

Angle = tuple[Array, Array, Array]
"""The hinge angle (n,) rad with its two derivatives."""


def hinge(options: Options, effects: list[Effect], t: Array, gravity: float, seed: int) -> World:
    """Return the hinge's motion under the true `gravity`."""
    rng = stream(seed, "motion")
    tempo = random_tempo(stream(seed, "tempo"), t, options.rest)
    declared: dict[str, object] = {"motion": "free" if options.swing else "hand", "base": options.base}
    if options.base == "fixed":
        first, R = clamped(rng, len(t), gravity)
        declared["base_quaternion"] = to_quaternion(R)
    else:
        first = hand_body(rng, tempo, options, gravity)
    swings: list[tuple[float, float]] = []
    hangs = 0.0
    if options.swing:
        body = limb(stream(seed, "body"), axis=0)
        declared["body"] = body.declared()
        law = torques(effects, body.about_y, t, stream(seed, "wind"))
        down = R.T @ np.array([0.0, 0.0, -gravity])
        hangs = _hangs(body, down)
        angle, swings = _swings(rng, t, options, law, body, down)
    else:
        rate = rng.uniform(2.0, 4.0) * options.vigour
        angle = angle_wave(rng, options.band, rate, rng.uniform(0.8, 1.4), rng.uniform(-0.3, 0.3)).along(tempo)
    return World(t, [first, hinged(first, angle, effects)], angle, swings, declared, hangs)


def hinged(first: Track, angle: Angle, effects: list[Effect]) -> Track:
    """Return segment 2 on segment 1 at a hinge angle, with what the joint does."""
    second = slid(first, angle, find(effects, "moving_centre"))
    second = second.rotated(1, *angle)
    second = coupled(second, angle, find(effects, "axis_coupling"))
    return played(second, find(effects, "joint_play"))


def hand_body(rng: np.random.Generator, tempo: Tempo, options: Options, gravity: float) -> Track:
    """Return a body that a hand moves and turns at will."""
    waves = [place_wave(rng, options.band, options.vigour * rng.uniform(2.0, 5.0)).along(tempo) for _ in range(3)]
    track = in_world(np.stack([w[0] for w in waves], -1), np.stack([w[2] for w in waves], -1), gravity)
    for axis, largest in ((2, 2.5), (1, 1.3), (0, 1.8)):
        rate = rng.uniform(1.0, 2.5) * options.vigour
        track = track.rotated(axis, *angle_wave(rng, options.band, rate, largest, rng.uniform(-0.5, 0.5)).along(tempo))
    return track


def clamped(rng: np.random.Generator, n: int, gravity: float) -> tuple[Track, Array]:
    """Return segment 1 clamped: the hinge axis within about 15 deg of horizontal, segment 2 hanging near q = 0."""
    R = about(2, rng.uniform(-3, 3)) @ about(0, rng.uniform(-0.25, 0.25)) @ about(1, np.pi / 2 + rng.uniform(-0.4, 0.4))
    return in_world(np.zeros((n, 3)), np.zeros((n, 3)), gravity).turned(R), R


def _hangs(body: Body, gravity: Array) -> float:
    """Return the hinge angle at which the com hangs below the axis, c(q) along g (3,) in axes of segment 1."""
    (cx, _, cz), (gx, _, gz) = body.com.tolist(), gravity.tolist()
    return float((atan2(-gz, gx) - atan2(-cz, cx) + pi) % (2 * pi) - pi)


def equation(law: Torques, body: Body, gravity: Array) -> Callable[[float, float, float], float]:
    """Return q'' rad/s^2 of an angle, its rate and the wind's torque, of a limb that swings on a clamped segment 1.

    (I_yy + m (cx^2 + cz^2)) q'' = m (c(q) x g)_y + torques, c(q) = Ry(q) c, g (3,) in axes of segment 1.
    """
    (cx, _, cz), (gx, _, gz) = (body.mass * body.com).tolist(), gravity.tolist()
    inertia = body.about_y / law.scale

    def accel(q: float, w: float, wind: float) -> float:
        c, s = cos(q), sin(q)
        pull = (cz * c - cx * s) * gx - (cx * c + cz * s) * gz
        return (pull + law.about(q, w) + law.along(abs(w)) * w + wind) / inertia

    return accel


def _swings(
    rng: np.random.Generator, t: Array, options: Options, law: Torques, body: Body, gravity: Array
) -> tuple[Angle, list[tuple[float, float]]]:
    """Return the hinge angle with derivatives when a hand lifts, holds, lets go and catches, again and again."""
    accel, hangs = equation(law, body, gravity), _hangs(body, gravity)
    q, w, a = np.full(len(t), hangs), np.zeros(len(t)), np.zeros(len(t))
    phases = plan(rng, t, options.seconds)
    for phase in phases:
        i, j, k = phase.lift, phase.hold, phase.release
        lift = float(rng.choice([-1, 1]) * rng.uniform(0.7, 1.5))
        up = hangs + (-lift if law.beyond(hangs + lift) else lift)
        q[i : j + 1], w[i : j + 1], a[i : j + 1] = joined(q[i], w[i], a[i], up, 0.0, j + 1 - i)
        q[j : k + 1], w[j : k + 1], a[j : k + 1] = up, 0.0, 0.0
        swing_hinge(q, w, a, k, phase.end, accel, law.wind)
    return (q, w, a), [phase.window for phase in phases]
