"""What is wrong with an IMU, as numbers in SI units."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np

from imubench.arrays import Array, frozen
from imubench.errors import InputError, unknown
from imubench.recording import positive

DROPOUT_MODES = ("missing", "held")


@dataclass(frozen=True)
class ChannelProfile:
    """The errors of a gyroscope (unit u = rad/s) or an accelerometer (u = m/s^2); the default has none.

    A `_std` beside `bias`, `scale` or `misalignment` adds a normal draw per entry that stays
    constant through the recording: parts differ, and switching on draws anew.
    Raises `InputError` when a number is negative, not finite or of the wrong shape, or when both
    ways to give the noise are used.
    """

    noise_density: float = 0.0  # u / sqrt(Hz), one-sided
    noise_std: float | None = None  # u per sample; instead of the density
    bias: Array = field(default_factory=lambda: np.zeros(3))  # (3,) u, sensor axes
    bias_std: float = 0.0  # u
    bias_random_walk: float = 0.0  # u / s / sqrt(Hz): variance bias_random_walk^2 t after t seconds
    bias_instability: float = 0.0  # u, stationary std of a first-order Gauss-Markov process
    bias_correlation_time: float = 100.0  # s, of that process
    scale: Array = field(default_factory=lambda: np.zeros(3))  # (3,) y_i = (1 + scale_i) x_i
    scale_std: float = 0.0
    misalignment: Array = field(default_factory=lambda: np.zeros(6))  # (6,) xy, xz, yx, yz, zx, zy
    misalignment_std: float = 0.0
    range: float | None = None  # u, readings are clipped at +- range; None: never
    step: float = 0.0  # u, readings are multiples of it; 0: not quantised
    bandwidth: float | None = None  # Hz, cut-off of a first-order low-pass; None: no filter

    def __post_init__(self) -> None:
        for key, size in (("bias", 3), ("scale", 3), ("misalignment", 6)):
            object.__setattr__(self, key, frozen(getattr(self, key), (size,), key))
        for key in (
            "noise_density", "bias_std", "bias_random_walk", "bias_instability",
            "scale_std", "misalignment_std", "step",
        ):  # fmt: skip
            positive(getattr(self, key), key, or_zero=True)
        positive(self.bias_correlation_time, "bias_correlation_time")
        for key in ("range", "bandwidth"):
            if getattr(self, key) is not None:
                positive(getattr(self, key), key)
        if self.noise_std is not None:
            positive(self.noise_std, "noise_std", or_zero=True)
            if self.noise_density:
                raise InputError("noise: expected noise_density or noise_std, got both")

    def sample_noise_std(self, rate: float) -> float:
        """Return the std (u) of one sample's noise at `rate` Hz, without rounding.

        Without a filter the sampler is taken to average over its period, N sqrt(rate / 2). Behind a
        first-order filter of cut-off fc nothing else limits the noise, so it folds: N sqrt(pi fc / 2).
        """
        if self.noise_std is not None:
            return self.noise_std
        noise_bandwidth = rate / 2 if self.bandwidth is None else np.pi * self.bandwidth / 2
        return self.noise_density * float(np.sqrt(noise_bandwidth))

    def declared_noise_std(self, rate: float) -> float:
        """Return the std (u) a laboratory measures per sample: noise, and rounding as step / sqrt(12)."""
        return float(np.hypot(self.sample_noise_std(rate), self.step / np.sqrt(12)))


@dataclass(frozen=True)
class ImuProfile:
    """An IMU: its two channels, what couples them, and how it samples.

    The sample stamped t shows the world at (t - clock_offset) / (1 + clock_skew), give or take the jitter.
    Raises `InputError` for a number out of its bounds or an unknown drop-out mode.
    """

    name: str
    rate: float  # Hz, on its own clock
    gyro: ChannelProfile = field(default_factory=ChannelProfile)
    accel: ChannelProfile = field(default_factory=ChannelProfile)
    g_sensitivity: Array = field(default_factory=lambda: np.zeros((3, 3)))  # (3, 3) rad/s per m/s^2
    jitter_std: float = 0.0  # s, of the sampling instant about its stamp
    clock_offset: float = 0.0  # s
    clock_skew: float = 0.0
    dropout_fraction: float = 0.0  # of the samples, each on its own
    dropout_mode: Literal["missing", "held"] = "missing"
    summary: str = ""  # one line
    sources: Mapping[str, str] = field(default_factory=dict)  # number -> where it comes from

    def __post_init__(self) -> None:
        where = f"profile {self.name}"
        positive(self.rate, f"{where}.rate")
        object.__setattr__(self, "g_sensitivity", frozen(self.g_sensitivity, (3, 3), f"{where}.g_sensitivity"))
        object.__setattr__(self, "sources", MappingProxyType(dict(self.sources)))
        positive(self.jitter_std, f"{where}.jitter_std", or_zero=True)
        positive(self.dropout_fraction, f"{where}.dropout_fraction", or_zero=True)
        if self.dropout_fraction >= 1:
            raise InputError(f"{where}.dropout_fraction: expected a fraction below 1, got {self.dropout_fraction:g}")
        if self.dropout_mode not in DROPOUT_MODES:
            raise unknown("dropout_mode", self.dropout_mode, DROPOUT_MODES)
        if np.ndim(self.clock_offset) or not np.isfinite(self.clock_offset):
            raise InputError(f"{where}.clock_offset: expected a finite number of seconds, got {self.clock_offset}")
        if np.ndim(self.clock_skew) or not abs(self.clock_skew) < 0.5:
            raise InputError(f"{where}.clock_skew: expected a number between -0.5 and 0.5, got {self.clock_skew}")
