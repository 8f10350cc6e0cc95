"""Could joint angles, positions, quaternions and levers be in the units of the format?"""

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.inputs.tables import Place

FASTEST_TURN = 70.0  # rad/s: MEMS gyroscopes end at 4000 deg/s
FASTEST_POINT = 100.0  # m/s
IMPOSSIBLE = 10.0  # times the fastest: not even a single reading, a knock or a spike of a tracker, does that
LARGEST_ANGLE = 1e6  # rad: turning as fast as can be, a joint gets there in four hours
LONGEST_LEVER = 10.0  # m


def check_angle(time: Array, angle: Array, place: Place, column: str) -> None:
    """Raise `InputError` for joint angles (n,) that no joint has: too large, or (as degrees are) turning too fast."""
    large = np.abs(np.nan_to_num(angle)) > LARGEST_ANGLE
    if large.any():
        row = int(large.argmax())
        raise InputError(
            f"{place(row)}, column '{column}': expected rad, at most {LARGEST_ANGLE:g}, got {angle[row]:.4g}"
        )
    _check_speed(time, angle[:, None], FASTEST_TURN, place, f"column '{column}'", "rad", "degrees")


def check_position(time: Array, position: Array, place: Place) -> None:
    """Raise `InputError` for positions (n, 3) that are millimetres: they would move too fast."""
    _check_speed(time, position, FASTEST_POINT, place, "position", "m", "millimetres")


def check_quaternions(quaternion: Array, place: Place, column: str) -> None:
    """Raise `InputError` unless every quaternion (n, 4) without NaN has norm 1 within 1e-2."""
    norm = np.linalg.norm(quaternion, axis=1)
    wrong = np.abs(norm - 1) > 1e-2
    if wrong.any():
        row = int(wrong.argmax())
        raise InputError(
            f"{place(row)}, {column}: expected a unit quaternion w, x, y, z, got {quaternion[row].tolist()} "
            f"of norm {norm[row]:.4g}"
        )


def check_lever(vector: Array, where: str) -> None:
    """Raise `InputError` for a vector (3,) that is no length of a rig in m."""
    length = float(np.linalg.norm(vector))
    if length > LONGEST_LEVER:
        raise InputError(
            f"{where}: expected a vector in m, under {LONGEST_LEVER:g} m long, got {vector.tolist()}: probably mm"
        )


def _check_speed(time: Array, values: Array, limit: float, place: Place, what: str, unit: str, likely: str) -> None:
    """Look at differences over at least 0.1 s, so that noise, steps of an encoder and wraps at pi stay below."""
    if time.size < 2:
        return
    stride = max(1, int(np.ceil(0.1 / float(np.median(np.diff(time))))))
    if time.size <= stride:
        return
    moved = values[stride:] - values[:-stride]
    seen = np.isfinite(moved).any(axis=1)
    speed = np.sqrt(np.nansum(moved**2, axis=1)) / (time[stride:] - time[:-stride])
    fast = speed > limit
    if fast.sum() >= max(5, 0.01 * seen.sum()):
        row = int(fast.argmax())
        raise InputError(
            f"{place(row)}, {what}: expected {unit}, got {float(speed[row]):.4g} {unit}/s: probably {likely}"
        )
    if fast.any() and speed.max() > IMPOSSIBLE * limit:
        row = int(speed.argmax()) + stride  # a reading that jumps there, or at its last
        raise InputError(
            f"{place(row)}, {what}: expected {unit} that change by under {IMPOSSIBLE * limit:g} {unit}/s, got "
            f"{float(speed.max()):.4g} {unit}/s from {stride} reading{'s' * (stride > 1)} before"
        )
