"""The spherical pendulum: a limb on a ball joint, hanging along -z; moved by hand, or swinging free.

By hand: R = Ry(b) Rx(c) Rz(a), tilts b and c and the axial turn a random. Its swing is q = atan2(R[0, 2], R[2, 2]),
with R[:, 2] = z, z' = R (w x e3), z'' = R (w' x e3 + w x (w x e3)).
"""

from dataclasses import replace

import numpy as np

from imubench.proof.body import Body, limb
from imubench.proof.frames import Track, in_world
from imubench.proof.motion import angle_wave, band_noise, random_tempo, steady
from imubench.proof.options import Effect, Options, World, find, stream
from imubench.proof.rotation import Array, about, apply, apply_back, euler_xyz, from_quaternion, to_quaternion
from imubench.proof.swing import Ball, joined, plan, swing_ball
from imubench.proof.torques import torques


def pendulum(options: Options, effects: list[Effect], t: Array, gravity: float, seed: int) -> World:
    """Return the pendulum's motion under the true `gravity`."""
    rng, pivot = stream(seed, "motion"), pivoted(effects, t, seed)
    if options.swing:
        track, windows, declared = _swings(rng, t, options, effects, gravity, pivot, seed)
        return World(t, [track], swing_of(track), windows, {"motion": "free", "body": declared})
    tempo = random_tempo(stream(seed, "tempo"), t, options.rest)
    track = in_world(*pivot, gravity)
    for axis, largest in ((1, 1.1), (0, 0.7), (2, 1.8)):
        rate = rng.uniform(1.5, 3.5) * options.vigour
        track = track.rotated(axis, *angle_wave(rng, options.band, rate, largest).along(tempo))
    return World(t, [track], swing_of(track), [], {"motion": "hand"})


def swing_of(track: Track) -> tuple[Array, Array, Array]:
    """Return the swing (n,) of a pendulum with its derivatives."""
    e = np.array([0.0, 0.0, 1.0])
    turn = np.cross(track.w, e)
    z, z1 = track.R[..., 2], apply(track.R, turn)
    z2 = apply(track.R, np.cross(track.dw, e) + np.cross(track.w, turn))
    (x, y), (x1, y1), (x2, y2) = ((v[:, 0], v[:, 2]) for v in (z, z1, z2))
    square = x**2 + y**2
    rate = (x1 * y - x * y1) / square
    return np.arctan2(x, y), rate, (x2 * y - x * y2) / square - rate * 2 * (x * x1 + y * y1) / square


def pivoted(effects: list[Effect], t: Array, seed: int) -> tuple[Array, Array]:
    """Return the pivot's place and acceleration (n, 3) in the world; on each axis `std` m/s^2 within `band` Hz."""
    moving, rng = find(effects, "moving_pivot"), stream(seed, "pivot")
    if moving is None:
        return np.zeros((len(t), 3)), np.zeros((len(t), 3))
    band = (float(moving["band"][0]), float(moving["band"][1]))
    waves = [band_noise(rng, band, float(moving["std"])) for _ in range(3)]
    place = [replace(w, amplitude=w.amplitude / (2 * np.pi * w.frequency) ** 2).along(steady(t)) for w in waves]
    return np.stack([x for x, _, _ in place], -1), np.stack([x2 for _, _, x2 in place], -1)


def _swings(
    rng: np.random.Generator,
    t: Array,
    options: Options,
    effects: list[Effect],
    gravity: float,
    pivot: tuple[Array, Array],
    seed: int,
) -> tuple[Track, list[tuple[float, float]], dict[str, object]]:
    """Return the motion when a hand lifts, lets go (turning about the limb's axis) and catches again."""
    body = limb(stream(seed, "body"), axis=2)
    ball = hung(body, effects, t, gravity, seed)
    law, n = ball.torques, len(t)
    R, w, dw = np.empty((n, 3, 3)), np.zeros((n, 3)), np.zeros((n, 3))
    R[:] = about(2, rng.uniform(-3, 3))
    phases = plan(rng, t, options.seconds)
    for phase in phases:
        side, tilt = rng.choice([-1, 1], 2), (rng.uniform(0.5, 1.1), rng.uniform(0.1, 0.5))
        if law.beyond(side[0] * tilt[0]):
            side[0] = -side[0]
        up = about(1, side[0] * tilt[0]) @ about(0, side[1] * tilt[1]) @ about(2, rng.uniform(-3, 3))
        i, k = phase.lift, phase.release
        part = slice(i, k + 1)
        R[part], w[part], dw[part] = lifted(R[i], w[i], dw[i], up, rng.uniform(-3, 3), k + 1 - i)
        state = [*to_quaternion(R[k]).tolist(), *w[k].tolist()]
        part = slice(k, phase.end + 1)
        states, dw[part] = swing_ball(ball, state, pivot[1][part], law.wind[part])
        R[part], w[part] = from_quaternion(states[:, :4]), states[:, 4:]
    return carried(pivot, R, w, dw, gravity), [phase.window for phase in phases], body.declared()


def hung(body: Body, effects: list[Effect], t: Array, gravity: float, seed: int) -> Ball:
    """Return a limb on its ball joint, with the torques of effects."""
    law = torques(effects, body.about_y, t, stream(seed, "wind"))
    mass = [float(x) for x in body.mass * body.com]
    return Ball((mass[0], mass[1], mass[2]), body.about_pivot / law.scale, gravity, law)


def carried(pivot: tuple[Array, Array], R: Array, w: Array, dw: Array, gravity: float) -> Track:
    """Return the limb's frame in the pivot, whose place and acceleration (n, 3) are those of the world."""
    return Track(pivot[0], R, w, dw, apply_back(R, pivot[1] + np.array([0.0, 0.0, gravity])))


def lifted(R: Array, w: Array, dw: Array, up: Array, spin: float, points: int) -> tuple[Array, Array, Array]:
    """Return attitude, rate and w' from a state (R, w, dw) to the attitude `up`, turning there at `spin` about z.

    R Rx(a) Ry(b) Rz(c) with quintics a, b, c; their first accelerations are chosen so that w' has no jump.
    """

    def turned(rates: Array, accels: Array, angles: list[Array]) -> Track:
        count = len(angles[0])
        track = Track(np.zeros((count, 3)), np.broadcast_to(R, (count, 3, 3)), *(np.zeros((count, 3)),) * 3)
        for axis in range(3):
            track = track.rotated(axis, angles[axis], rates[axis], accels[axis])
        return track

    start = turned(w[:, None], np.zeros((3, 1)), [np.zeros(1)] * 3)
    first, end = dw - start.dw[0], euler_xyz(R.T @ up)
    parts = [joined(0.0, w[a], first[a], end[a], spin if a == 2 else 0.0, points) for a in range(3)]
    track = turned(np.array([p[1] for p in parts]), np.array([p[2] for p in parts]), [p[0] for p in parts])
    return track.R, track.w, track.dw
