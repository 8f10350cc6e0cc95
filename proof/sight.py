"""What the readings of a rig and its motion can show: their changes by a motion, by the mounts, and what is left.

Whitened by the case's own noise, with its colour, the louder noise and the rounding among its effects. A is the change
by a motion that is free up to a band (quintic B-splines), G that by the mounts, known as well as declared. Free swings,
where the motion is not free, have no such view.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import splu

from imubench.proof.colour import with_colour
from imubench.proof.instruments import POSITION_NOISE, ROTATION_NOISE
from imubench.proof.linearised import Block, blocks, components
from imubench.proof.mounts import Mount, sensor_track
from imubench.proof.options import Effect, find
from imubench.proof.played import Case, played, sensed
from imubench.proof.rotation import Array, exp
from imubench.proof.sensors import CHANNELS, noise_std, read_imu

UNKNOWN_POSITION, UNKNOWN_ROTATION = 0.05, 0.2  # m, rad, where a recording does not declare them
BASIS = BSpline.basis_element(np.arange(7.0), extrapolate=False)


def motion_columns(case: Case, parts: list[Block], knots_per_s: float) -> csc_matrix:
    """Return A, the whitened change of all readings by each spline coefficient of the motion."""
    c, rows, columns, values, first = components(case), [], [], [], 0
    for block in parts:
        place = (block.time + 1.0) * knots_per_s
        base = np.floor(place).astype(int)
        local = (place - base)[:, None] + np.arange(6)[::-1]  # of the six bases that reach here
        B = [np.nan_to_num(BASIS.derivative(k)(local) if k else BASIS(local)) * knots_per_s**k for k in range(3)]
        entry = sum(S[:, :, None, :] * b[:, None, :, None] for S, b in zip(block.S, B, strict=True)) / block.std
        m, k = block.S[0].shape[:2]
        shape = (m, k, 6, c)
        row = first + np.arange(m * k).reshape(m, k, 1, 1)
        column = c * (base[:, None, None, None] + np.arange(6)[:, None]) + np.arange(c)
        rows.append(np.broadcast_to(row, shape).ravel())
        columns.append(np.broadcast_to(column, shape).ravel())
        values.append(np.asarray(entry).ravel())
        first += m * k
    r, j, v = (np.concatenate(x) for x in (rows, columns, values))
    return csc_matrix((v, (r, j)), shape=(first, int(j.max()) + 1))


@dataclass
class Sight:
    """What motion and geometry leave of a change of the readings, for one motion of one rig."""

    case: Case  # without effect, noise or lost samples
    parts: list[Block]
    A: csc_matrix
    factor: Any
    G: Array  # (rows, 6 per IMU), after the motion
    prior: Array  # 1 / std^2 of the geometry

    def left(self, change: Array) -> Array:
        """Return the whitened change (rows, k) without what a motion, or coloured noise, could explain."""
        change = np.pad(change, ((0, self.A.shape[0] - len(change)), (0, 0)))  # the laws of coloured noise know none
        left = change - self.A @ self.factor.solve(self.A.T @ change)
        return np.asarray(left - self.A @ self.factor.solve(self.A.T @ left))  # once more, against the ridge

    def information(self, change: Array, mounts: slice = slice(None)) -> Array:
        """Return the Fisher information (k, k) of whitened changes (rows, k), motion and geometry unknown.

        `mounts`: the part of the geometry that is unknown, six numbers for each IMU.
        """
        left, G = self.left(change), self.G[:, mounts]
        cross = G.T @ left
        inner = G.T @ G + np.diag(self.prior[mounts])
        return np.asarray(left.T @ left - cross.T @ np.linalg.solve(inner, cross))

    def readings(self, effects: list[Effect]) -> Array:
        """Return all readings (rows,) over their noise with these effects; at IMUs they leave the motion as it is."""
        options, seed, world = self.case.options, self.case.seed, self.case.world
        at_imus = all(e.at.startswith("imu") for e in effects)
        case = sensed(options, effects, seed, world) if at_imus else played(options, effects, seed)
        return stacked(case, self.parts)


def sight(case: Case, knots_per_s: float | None = None) -> Sight | None:
    """Return how a case's rig and motion see; None for free swings. The motion is free to 6 times its band or more.

    Sensors sit where they are, a `mount_pose` counted: seen from where they should be, 0.35 rad off, a turn about the
    hinge, which a free hinge's angle takes up, was known to 0.6 mrad.
    """
    options = replace(case.options, noise=0.0, colour=0.0, gaps=0, repeats=0)
    if options.swing:
        return None
    plain = replace(played(options, [], case.seed), mounts=as_they_are(case))
    parts = [*blocks(plain, {name: noise_of(case, name) for name in channels(plain)}), *_instruments(plain)]
    knots = knots_per_s or float(np.clip(12 * options.band, 25.0, options.rate))
    motion = motion_columns(plain, parts, knots)
    A = with_colour(motion, case, parts)
    N = (A.T @ A).tocsc()
    N = N + diags(np.where(np.arange(N.shape[0]) < motion.shape[1], 1e-9 * N.diagonal().max(), 0.0))
    seen = Sight(plain, parts, A, splu(N), np.zeros((A.shape[0], 0)), np.zeros(0))
    G, prior = geometry(seen)
    seen.G, seen.prior = seen.left(G), prior
    return seen


def as_they_are(case: Case) -> list[Mount]:
    """Return the mounts of a case with what `mount_pose` moves them by."""
    out = []
    for i, mount in enumerate(case.mounts):
        p = find(case.effects, "mount_pose", f"imu{i + 1}") or {}
        place = mount.position + np.asarray(p.get("translation", np.zeros(3)), dtype=float)
        turn = mount.rotation @ exp(np.asarray(p.get("rotation", np.zeros(3)), dtype=float))
        out.append(replace(mount, position=place, rotation=turn))
    return out


def channels(case: Case) -> list[str]:
    """Return "imu1.gyro" and so on."""
    return [f"imu{i + 1}.{channel}" for i in range(len(case.imus)) for channel in CHANNELS]


def noise_of(case: Case, name: str) -> float:
    """Return a channel's noise per sample with what is louder by an effect, and with rounding as a white noise."""
    at, channel = name.split(".")
    std, _ = noise_std(channel, at, case.effects, replace(case.options, noise=1.0))
    rounding = find(case.effects, "quantisation", at)
    step = float(rounding["step"]) if rounding and channel in rounding.get("channels", CHANNELS) else 0.0
    return float(np.hypot(std, step / np.sqrt(12)))


def stacked(case: Case, parts: list[Block]) -> Array:
    """Return all readings (rows,) over their noise, those of instruments as nought: no effect changes these."""
    values = []
    for block in parts:
        imu, _, channel = block.name.partition(".")
        if channel:
            values.append(getattr(case.imus[int(imu[-1]) - 1], channel).ravel() / block.std)
        else:
            values.append(np.zeros(block.S[0].shape[0] * block.S[0].shape[1]))
    return np.concatenate(values)


def _instruments(case: Case) -> list[Block]:
    """Return the encoder's and the pose's readings, which see the motion and no effect of an IMU."""
    c, time = components(case), np.arange(0.0, case.options.seconds, 0.01)
    one = np.broadcast_to(np.eye(c), (len(time), c, c))
    none = np.zeros_like(one)

    def block(name: str, std: float, first: int, last: int) -> Block:
        return Block(name, time, std, (one[:, first:last], none[:, first:last], none[:, first:last]))

    if case.options.shape.hinge and case.options.encoder:
        return [block("encoder", 5e-4, c - 1, c)]
    if not case.options.shape.jointed and case.options.pose is not False:
        return [block("turn", ROTATION_NOISE, 0, 3), block("place", POSITION_NOISE, 3, 6)]
    return []


def geometry(seen: Sight) -> tuple[Array, Array]:
    """Return the change of all readings by each mount's position and rotation, and 1 / std^2 of what is declared."""
    case, options, step = seen.case, seen.case.options, 1e-4
    declared = options.declare_geometry
    position = options.position_std if declared else UNKNOWN_POSITION
    rotation = options.rotation_std if declared else UNKNOWN_ROTATION
    columns = []
    for i, mount in enumerate(case.mounts):
        for k in range(6):
            by = step * np.eye(6)[k]
            moved = Mount(mount.position + by[:3], mount.rotation @ exp(by[3:]), mount.position, mount.rotation)
            at, rate = f"imu{i + 1}", case.rates[i]
            track = sensor_track(case.world, case.world.segments[i], moved, at, [])
            imus = list(case.imus)
            imus[i] = read_imu(track, at, [], options, rate, case.seed)
            columns.append((stacked(replace(case, imus=imus), seen.parts) - stacked(case, seen.parts)) / step)
    return np.stack(columns, -1), np.tile([position**-2.0] * 3 + [rotation**-2.0] * 3, len(case.mounts))
