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
from imubench.proof.linear import middles
from imubench.proof.options import Effect, find
from imubench.proof.rotation import Array, Parameters, apply, skew

NAMES = (
    "bias_jump", "thermal_walk", "hysteresis", "cubic", "rectification", "cross_talk", "dead_band", "creep",
    "hardening_mount", "cogging", "wind",
)  # fmt: skip
STILL_ROUNDS = 30


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
    """Return the frame of a mass on hardening springs; it begins where it hangs still (Runge and Kutta, fourth order).

    Raises FloatingPointError where the motion is too violent for the springs and the grid.
    """
    rate = 2 * np.pi * float(parameters["frequency"])
    damping, cubic = 2 * float(parameters["damping_ratio"]) * rate, (rate / float(parameters["span"])) ** 2
    W = skew(track.w)
    plain, drag = -(rate**2) * np.eye(3) - skew(track.dw) - W @ W, -damping * np.eye(3) - 2 * W
    A, f = np.concatenate([plain, drag], axis=2), -track.f  # (n, 3, 6), (n, 3)

    def slope(A: Array, f: Array, x: Array) -> Array:
        return np.concatenate([x[3:], A @ x + f - cubic * x[:3] ** 3])

    x = np.zeros((len(f), 6))
    x[0, :3] = _still(plain[0], f[0], cubic)
    with np.errstate(over="ignore", invalid="ignore"):
        for i, (Am, fm) in enumerate(zip(middles(A), middles(f), strict=True)):
            k1 = slope(A[i], f[i], x[i])
            k2 = slope(Am, fm, x[i] + STEP / 2 * k1)
            k3 = slope(Am, fm, x[i] + STEP / 2 * k2)
            k4 = slope(A[i + 1], f[i + 1], x[i] + STEP * k3)
            x[i + 1] = x[i] + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    if not np.isfinite(x).all():
        raise FloatingPointError(f"a hardening mount of {parameters['frequency']} Hz leaves every bound")
    accel = apply(plain, x[:, :3]) + apply(drag, x[:, 3:]) + f - cubic * x[:, :3] ** 3
    return track.placed(x[:, :3], x[:, 3:], accel)


def _still(plain: Array, f: Array, cubic: float) -> Array:
    """Return the place (3,) where springs and specific force balance, by Newton's method from the linear springs'."""
    s = np.linalg.solve(plain, -f)
    for _ in range(STILL_ROUNDS):
        s = np.linalg.solve(plain - 3 * cubic * np.diag(s**2), -f - 2 * cubic * s**3)
    return np.asarray(s)
