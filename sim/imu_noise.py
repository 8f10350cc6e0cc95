"""The random parts of an IMU's errors; each source draws from a generator of its own.

Arrays are (n, 3): one row a sample, one independent process an axis. Equations and their Allan
deviations are in docs/imu-profiles.md (after IEEE Std 952-1997, annex C).
"""

import numpy as np

from imubench.arrays import Array
from imubench.sim.imu_profile import ChannelProfile

SOURCES = (
    "jitter", "dropouts",
    "gyro.noise", "gyro.bias", "gyro.random_walk", "gyro.instability", "gyro.scale", "gyro.misalignment",
    "accel.noise", "accel.bias", "accel.random_walk", "accel.instability", "accel.scale", "accel.misalignment",
)  # fmt: skip
"""One generator each, in this order: append new sources at the end, or old seeds give other recordings."""

Draws = dict[str, np.random.Generator]


def spawn_sources(rng: np.random.Generator) -> Draws:
    """Return one independent generator per error source, so that none moves another's draws."""
    return dict(zip(SOURCES, rng.spawn(len(SOURCES)), strict=True))


def gauss_markov(rng: np.random.Generator, count: int, std: float, decay: float) -> Array:
    """Return x_k = decay x_(k-1) + std sqrt(1 - decay^2) n_k, stationary from the first sample on.

    Autocovariance std^2 decay^|lag|: a first-order process sampled exactly; `decay` 0 is white noise.
    """
    from scipy.signal import lfilter  # here: long to import, and most commands do without

    drive = rng.standard_normal((count, 3))
    drive[0] *= std
    drive[1:] *= std * np.sqrt(1 - decay**2)
    if not decay:
        return drive
    return np.asarray(lfilter([1.0], [1.0, -decay], drive, axis=0))


def random_walk(rng: np.random.Generator, count: int, density: float, period: float) -> Array:
    """Return b_k = b_(k-1) + density sqrt(period) n_k from b_0 = 0: variance density^2 t."""
    steps = density * np.sqrt(period) * rng.standard_normal((count, 3))
    steps[0] = 0.0
    return np.asarray(np.cumsum(steps, axis=0))


def additive_errors(channel: ChannelProfile, kind: str, draws: Draws, count: int, rate: float) -> Array:
    """Return bias, its random walk, its instability and noise, summed, (count, 3).

    `kind` is "gyro" or "accel". All run on the nominal period 1 / rate, jitter apart.
    """
    noise_decay = 0.0 if channel.bandwidth is None else float(np.exp(-2 * np.pi * channel.bandwidth / rate))
    bias_decay = float(np.exp(-1 / (rate * channel.bias_correlation_time)))
    constant = channel.bias + channel.bias_std * draws[f"{kind}.bias"].standard_normal(3)
    total = np.tile(constant, (count, 1))
    if channel.bias_random_walk:
        total += random_walk(draws[f"{kind}.random_walk"], count, channel.bias_random_walk, 1 / rate)
    if channel.bias_instability:
        total += gauss_markov(draws[f"{kind}.instability"], count, channel.bias_instability, bias_decay)
    if noise_std := channel.sample_noise_std(rate):
        total += gauss_markov(draws[f"{kind}.noise"], count, noise_std, noise_decay)
    return total


def linear_errors(channel: ChannelProfile, kind: str, draws: Draws) -> Array:
    """Return the matrix diag(s) + M (3, 3) of scale and misalignment that acts on the true signal."""
    scale = channel.scale + channel.scale_std * draws[f"{kind}.scale"].standard_normal(3)
    entries = channel.misalignment + channel.misalignment_std * draws[f"{kind}.misalignment"].standard_normal(6)
    matrix = np.diag(scale)
    matrix[~np.eye(3, dtype=bool)] = entries  # row by row: xy, xz, yx, yz, zx, zy
    return matrix
