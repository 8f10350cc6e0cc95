"""Arrays that are checked once, when they are made, and frozen from then on; the size of one."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from imubench.errors import InputError, shown

Array = NDArray[np.float64]
SHORTEST_STEP = 1e-10  # s between samples: no clock of a sensor tells stamps apart that are nearer


def frozen(value: ArrayLike, shape: tuple[int | None, ...], name: str, finite: bool = True) -> Array:
    """Return `value` as a read-only float array of `shape` (None: any length).

    Raises `InputError` when the shape differs or, if `finite`, a value is not finite.
    """
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name}: expected numbers, got {shown(value)}") from None
    fits = array.ndim == len(shape) and all(
        want is None or want == got for want, got in zip(shape, array.shape, strict=True)
    )
    if not fits:
        want = "(" + ", ".join("n" if s is None else str(s) for s in shape) + ")"
        raise InputError(f"{name}: expected shape {want}, got {array.shape}")
    if finite and not np.isfinite(array).all():
        row = int(np.argwhere(~np.isfinite(array))[0][0]) if array.ndim else 0
        raise InputError(f"{name}: expected finite numbers, got {array[row]} in row {row}")
    array.flags.writeable = False
    return array


def frozen_time(value: ArrayLike, name: str) -> Array:
    """Return sample times (n,) in s, strictly increasing, read-only."""
    time = frozen(value, (None,), name)
    if time.size == 0:
        raise InputError(f"{name}: expected at least one sample, got none")
    step = np.diff(time)
    if (step < SHORTEST_STEP).any():
        row = int(np.argmax(step < SHORTEST_STEP)) + 1
        what = "a repeated stamp" if step[row - 1] >= 0 else "time running backwards"
        raise InputError(
            f"{name}: expected increasing time, got {what} in row {row}: {time[row]:g} s after {time[row - 1]:g} s"
        )
    return time


def frozen_quaternion(value: ArrayLike, name: str) -> Array:
    """Return one unit quaternion (4,), wxyz, read-only; `InputError` if its norm is off by more than 1e-3."""
    q = frozen(value, (4,), name)
    norm = float(np.linalg.norm(q))
    if abs(norm - 1.0) > 1e-3:
        raise InputError(f"{name}: expected a unit quaternion w, x, y, z, got {q.tolist()} of norm {norm:.4g}")
    return q


def rms(x: Array) -> float:
    """Return the root of the mean square of some numbers."""
    return float(np.sqrt(np.mean(x**2)))
