"""From the dense, evenly spaced truth to an IMU's own samples: low-pass, clock, interpolation, drop-outs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.sim.imu_profile import ImuProfile

SNAP = 1e-6  # of a dense step: a sampling instant this close to a dense sample is that sample


@dataclass(frozen=True)
class SamplingPlan:
    """When an IMU samples: what it stamps, and where on the dense grid the world then is."""

    stamps: Array  # (m,) s, the IMU's clock
    positions: Array  # (m,) in dense steps from the first dense sample


def low_pass(signal: Array, step: float, cutoff: float) -> Array:
    """Return `signal` (n, 3), every `step` s, behind a causal first-order low-pass of `cutoff` Hz.

    Exact for a signal that is linear between its samples; it starts settled on the first sample and lags
    by 1 / (2 pi cutoff) s at low frequency.
    """
    from scipy.signal import lfilter  # here: long to import, and most commands do without

    omega = 2 * np.pi * cutoff * step
    decay = np.exp(-omega)
    mean_decay = -np.expm1(-omega) / omega
    now, before = 1 - mean_decay, mean_decay - decay
    filtered, _ = lfilter([now, before], [1.0, -decay], signal, axis=0, zi=(1 - now) * signal[:1])
    return np.asarray(filtered)


def dense_step(time: Array) -> float:
    """Return the step (s) of the truth's `time` (n,); `InputError` unless it is evenly spaced."""
    if time.size < 2:
        raise InputError(f"truth.time: expected at least 2 samples, got {time.size}")
    step = float(time[-1] - time[0]) / (time.size - 1)
    off = np.abs(np.diff(time) - step)
    if not off.max() < 1e-3 * step:
        row = int(np.argmax(off)) + 1
        raise InputError(
            f"truth.time: expected evenly spaced samples, got {time[row] - time[row - 1]:g} s in row {row}"
        )
    return step


def sampling_plan(time: Array, profile: ImuProfile, rng: np.random.Generator) -> SamplingPlan:
    """Return where and with which stamps `profile` samples the truth's `time` (n,).

    The first sample falls on the first dense one; the next follow every 1 / rate s of the IMU's clock, which
    reads (1 + skew) t + offset at world time t. Jitter moves the instant and not the stamp.
    """
    step = dense_step(time)
    last = time.size - 1
    stride = 1 / (step * profile.rate * (1 + profile.clock_skew))
    nominal = np.arange(int(last / stride + SNAP) + 1) * stride
    nearest = np.rint(nominal)
    on_grid = np.abs(nominal - nearest) < SNAP
    nominal = np.where(on_grid, nearest, nominal)
    world = np.where(on_grid, time[nearest.astype(int).clip(max=last)], time[0] + nominal * step)
    positions = nominal
    if profile.jitter_std:
        shift = profile.jitter_std / step * rng.standard_normal(nominal.size)
        positions = np.clip(nominal + shift, 0, last)
    stamps = (1 + profile.clock_skew) * world + profile.clock_offset
    return SamplingPlan(np.asarray(stamps, dtype=float), np.asarray(positions, dtype=float))


def interpolate(signal: Array, positions: Array) -> Array:
    """Return `signal` (n, 3) at fractional `positions` (m,), by cubics through the four nearest samples.

    On a sample it is that sample, bit by bit. In between, the error is at most 3/128 h^4 max|f''''|, and
    1/24 h^4 max|f''''| in the first and the last interval; h is the dense step.
    """
    whole = np.floor(positions).astype(int)
    if np.array_equal(whole, positions):
        return np.asarray(signal[whole])
    if len(signal) < 4:
        raise InputError(f"truth: expected at least 4 samples to interpolate between, got {len(signal)}")
    first = np.clip(whole - 1, 0, len(signal) - 4)
    s = (positions - first)[:, None]
    a, b, c, d = s, s - 1, s - 2, s - 3
    return np.asarray(
        signal[first] * (b * c * d / -6)
        + signal[first + 1] * (a * c * d / 2)
        + signal[first + 2] * (a * b * d / -2)
        + signal[first + 3] * (a * b * c / 6)
    )


def kept_rows(count: int, profile: ImuProfile, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return the source row of every sample that comes out: fewer than `count` (missing) or repeated (held).

    Each sample is lost on its own with the profile's fraction; the first never is.
    """
    rows = np.arange(count)
    if not profile.dropout_fraction:
        return rows
    lost = rng.random(count) < profile.dropout_fraction
    lost[0] = False
    if profile.dropout_mode == "missing":
        return rows[~lost]
    return np.maximum.accumulate(np.where(lost, 0, rows))
