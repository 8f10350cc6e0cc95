"""Physics that the table of effects does not have. A diagnosis should say that something is there, and where.

bias_jump        `jump` (3) is added to `channel` from `time` on
thermal_walk     `channel` drifts along a random walk of `density` per root second on each axis
hysteresis       `channel` reads x + share (play(x) - x), play: follows x only beyond +- `width`
cubic            `channel` reads x + `factor` x^3, axis by axis
rectification    the accelerometer reads + `factor` (3) P, P the power of its shaking above 2 Hz over 0.5 s
cross_talk       gyro axis `to` reads + `share` of gyro axis `from`, `delay` s late
dead_band        `channel` reads x - clip(x, -width, width)
creep            the mount turns by `rotation` (1 - exp(-t / `time_constant`))
hardening_mount  a soft mount with springs K x (1 + (x / `span`)^2), axis by axis
cogging, wind    torques in a free swing, see `torques`
"""

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

from imubench.proof.frames import STEP, Track
from imubench.proof.linear import solve
from imubench.proof.options import Effect, find
from imubench.proof.rotation import Array, Parameters, apply, skew

NAMES = (
    "bias_jump", "thermal_walk", "hysteresis", "cubic", "rectification", "cross_talk", "dead_band", "creep",
    "hardening_mount", "cogging", "wind",
)  # fmt: skip
HARDENING_ROUNDS = 12


def on_the_signal(at: str, effects: list[Effect], signals: dict[str, Array]) -> dict[str, Array]:
    """Return what `gyro` and `accel` (n, 3) add to themselves on the fine grid, by the laws above."""
    extra = {channel: np.zeros_like(x) for channel, x in signals.items()}
    if p := find(effects, "hysteresis", at):
        x = signals[p["channel"]]
        extra[p["channel"]] += float(p["share"]) * (play(x, float(p["width"])) - x)
    if p := find(effects, "cubic", at):
        extra[p["channel"]] += float(p["factor"]) * signals[p["channel"]] ** 3
    if p := find(effects, "dead_band", at):
        width = float(p["width"])
        extra[p["channel"]] -= np.clip(signals[p["channel"]], -width, width)
    if p := find(effects, "cross_talk", at):
        late = round(float(p["delay"]) / STEP)
        source = signals["gyro"][:, p["from"]]
        extra["gyro"][:, p["to"]] += float(p["share"]) * np.concatenate([np.full(late, source[0]), source[:-late]])
    if p := find(effects, "rectification", at):
        extra["accel"] += np.outer(shaking(signals["accel"]), np.asarray(p["factor"], dtype=float))
    return extra


def on_the_samples(
    at: str, effects: list[Effect], time: Array, channel: str, rng: np.random.Generator
) -> Array | float:
    """Return what `bias_jump` and `thermal_walk` add to the samples (m, 3) of one channel."""
    extra: Array | float = 0.0
    p = find(effects, "bias_jump", at)
    if p and p["channel"] == channel:
        extra = extra + np.outer(time >= float(p["time"]), np.asarray(p["jump"], dtype=float))
    p = find(effects, "thermal_walk", at)
    if p and p["channel"] == channel:
        steps = (
            float(p["density"]) * np.sqrt(np.diff(time, prepend=time[0]))[:, None] * rng.standard_normal((len(time), 3))
        )
        extra = extra + np.cumsum(steps, axis=0)
    return extra


def play(x: Array, width: float) -> Array:
    """Return the play operator of x (n,) or (n, k): y follows x as soon as |x - y| would exceed `width`."""
    if x.ndim == 2:
        return np.stack([play(column, width) for column in x.T], axis=-1)
    y, here = [], float(x[0])
    for value in x.tolist():
        here = min(max(here, value - width), value + width)
        y.append(here)
    return np.array(y)


def shaking(accel: Array) -> Array:
    """Return the power (n,) (m/s^2)^2 of a specific force (n, 3) above 2 Hz, smoothed over 0.5 s."""
    fast = sosfilt(butter(2, 2.0, "highpass", fs=1 / STEP, output="sos"), accel - accel[0], axis=0)
    decay = np.exp(-STEP / 0.5)
    return np.asarray(lfilter([1 - decay], [1, -decay], (fast**2).sum(axis=1)))


def creep(t: Array, time_constant: float) -> tuple[Array, Array, Array]:
    """Return how far a mount has crept at t, 0 to 1, with two derivatives; before 0 it stands still."""
    late = np.where(t > 0, np.exp(-np.maximum(t, 0) / time_constant), 1.0)
    return 1 - late, late / time_constant * (t > 0), -late / time_constant**2 * (t > 0)


def hardening(track: Track, parameters: Parameters) -> Track:
    """Return the frame of a mass on hardening springs, by Newton's method on the whole motion (quasi-linearised).

    Raises FloatingPointError where the motion is too violent for the springs and the grid.
    """
    n = len(track.w)
    rate = 2 * np.pi * float(parameters["frequency"])
    damping, cubic = 2 * float(parameters["damping_ratio"]) * rate, (rate / float(parameters["span"])) ** 2
    W = skew(track.w)
    A, b = np.zeros((n, 6, 6)), np.zeros((n, 6))
    A[:, :3, 3:] = np.eye(3)
    A[:, 3:, 3:] = -damping * np.eye(3) - 2 * W
    plain = -(rate**2) * np.eye(3) - skew(track.dw) - W @ W
    A[:, 3:, :3] = plain
    b[:, 3:] = -track.f
    x = solve(A, b, np.linalg.solve(A[0], -b[0]), STEP)
    for _ in range(HARDENING_ROUNDS):
        s = x[:, :3]
        A[:, 3:, :3] = plain - 3 * cubic * s[:, :, None] ** 2 * np.eye(3)
        b[:, 3:] = -track.f + 2 * cubic * s**3
        with np.errstate(over="ignore", invalid="ignore"):
            last, x = x, solve(A, b, np.linalg.solve(A[0], -b[0]), STEP)
        if not np.isfinite(x).all():
            raise FloatingPointError(f"a hardening mount of {parameters['frequency']} Hz leaves every bound")
        if np.abs(x[:, :3] - last[:, :3]).max() < 1e-9:
            break
    else:
        raise FloatingPointError(f"no motion of a hardening mount found in {HARDENING_ROUNDS} rounds")
    accel = apply(plain, x[:, :3]) + apply(A[:, 3:, 3:], x[:, 3:]) - track.f - cubic * x[:, :3] ** 3
    return track.placed(x[:, :3], x[:, 3:], accel)
