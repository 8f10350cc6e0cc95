"""Sample selection for a hinge axis: Olsson 2020, section 5, Algorithms 2 and 3, on all samples at once.

`selection_gyro` has Algorithm 2, `selection_accel` the three forms of Algorithm 3, `selection_online` both for
samples that arrive in batches. What the paper leaves open, and how it is read here: docs/sample-selection.md.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array, frozen
from imubench.errors import InputError, unknown
from imubench.estimators.selection_accel import ENERGY_THRESHOLD, FORMS, penalties, pick_accel
from imubench.estimators.selection_gyro import HALF_WIDTH, Index, gyro_scores, pick_gyro, rate_differences


@dataclass(frozen=True)
class Selected:
    """The samples that were selected, in the order of time."""

    gyro: Index  # (g,) sample numbers from the first sample on
    accel: Index  # (a,)
    gyro1: Array  # (g, 3) rad/s
    gyro2: Array  # (g, 3) rad/s
    accel1: Array  # (a, 3) m/s^2
    accel2: Array  # (a, 3) m/s^2


@dataclass(frozen=True)
class Settings:
    """The parameters of Algorithms 2 and 3, section 7.3 of the paper; `InputError` for what cannot be."""

    n_max: int  # samples of either kind to keep at most
    half_width: int = HALF_WIDTH  # samples
    threshold: float = ENERGY_THRESHOLD  # rad^2/s^2
    form: str = "printed"  # of Algorithm 3, one of FORMS

    def __post_init__(self) -> None:
        """Check every parameter."""
        if self.n_max < 1:
            raise InputError(f"n_max: expected at least 1 sample, got {self.n_max}")
        if self.half_width < 0:
            raise InputError(f"half_width: expected 0 or more samples, got {self.half_width}")
        if not (np.isfinite(self.threshold) and self.threshold >= 0):
            raise InputError(f"threshold: expected a finite energy of 0 or more rad^2/s^2, got {self.threshold}")
        if self.form not in FORMS:
            raise unknown("form of Algorithm 3", self.form, FORMS)


def four(gyro1: ArrayLike, gyro2: ArrayLike, accel1: ArrayLike, accel2: ArrayLike) -> tuple[Array, ...]:
    """Return the four arrays (n, 3), checked: finite, and of one length."""
    names = ("gyro1", "gyro2", "accel1", "accel2")
    arrays = tuple(frozen(v, (None, 3), name) for v, name in zip((gyro1, gyro2, accel1, accel2), names, strict=True))
    for array, name in zip(arrays, names, strict=True):
        if len(array) != len(arrays[0]):
            raise InputError(f"{name}: expected {len(arrays[0])} samples as in gyro1, got {len(array)}")
    return arrays


def select(
    gyro1: ArrayLike,
    gyro2: ArrayLike,
    accel1: ArrayLike,
    accel2: ArrayLike,
    n_max: int,
    half_width: int = HALF_WIDTH,
    threshold: float = ENERGY_THRESHOLD,
    form: str = "printed",
) -> Selected:
    """Select at most `n_max` gyroscope and `n_max` accelerometer samples from all.

    gyro (n, 3) in rad/s and accel (n, 3) in m/s^2 of both sensors, at the same times; the rest as `Settings`.
    Raises `InputError` for arrays of other shapes, of different lengths or not finite, and for bad settings.
    """
    settings = Settings(n_max, half_width, threshold, form)
    w1, w2, a1, a2 = four(gyro1, gyro2, accel1, accel2)
    gyro = pick_gyro(gyro_scores(rate_differences(w1, w2), half_width), n_max)
    accel = pick_accel(np.hstack([a1, -a2]), penalties(w1, w2, half_width), n_max, threshold, settings.form)
    return Selected(gyro, accel, w1[gyro], w2[gyro], a1[accel], a2[accel])
