"""How the signs of two hinge axes go together, and what says so.

(j1, j2) and (j1, -j2) are the same two lines, but other hinges. Gyroscopes cannot tell them apart: |w x j| does not
change with the sign of j. Accelerometers can, as far as there is specific force along the hinge: both must read the
same, j1 . a1 = j2 . a2 (Olsson 2020, eq. 25). Otherwise whoever mounted the sensors knows it, if he says how well.
"""

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.estimate import Pairing
from imubench.recording import Recording

COMMON = 0.3  # m/s^2 rms, what both must read alike along the hinge: more than a calibrated accelerometer's bias (0.1)
COHERENT = 0.5  # how much of what each reads along the hinge must be common to both; the rest is lever arms and noise
SURE = 3.0  # standard deviations that a declared mount may be off and still tell a sign


def along_y(recording: Recording, axes: Array) -> Array:
    """Return the components (2,) of axes (2, 3) along +y of their segments, by the declared mounts."""
    mounts = np.stack([recording.imu(name).mount_quaternion for name in ("imu1", "imu2")])
    return np.asarray(rotations.rotate(mounts, axes)[:, 1])


def toward_y(recording: Recording, axes: Array) -> Array:
    """Return axes (2, 3), each with the sign that points along +y of its segment, by the declared mounts."""
    return np.asarray(axes * np.where(along_y(recording, axes) < 0, -1.0, 1.0)[:, None])


def told_by_data(accel1: Array, accel2: Array, axes: Array) -> bool:
    """Tell whether specific forces (n, 3) of both IMUs back the signs that the axes (2, 3) have.

    The mean of (j1 . a1)(j2 . a2) is the power of what both feel along the hinge: positive where the signs are right.
    Biases alone make it up to their product, of any sign, and lever arms make the two differ.
    """
    if not len(accel1):
        return False
    along1, along2 = accel1 @ axes[0], accel2 @ axes[1]
    common = float(np.mean(along1 * along2))
    power = float(np.mean(along1**2) * np.mean(along2**2))
    return common > COMMON**2 and common > COHERENT * power**0.5


def told_by_mounts(recording: Recording, axes: Array) -> bool:
    """Tell whether the declared mounts give the sign of both axes (2, 3), even if each is three std off."""
    stds = [recording.imu(name).mount_rotation_std for name in ("imu1", "imu2")]
    off = np.arccos(np.clip(np.abs(along_y(recording, axes)), 0.0, 1.0))  # rad, from the declared axis, a sign aside
    return all(std is not None and angle + SURE * std < np.pi / 2 for std, angle in zip(stds, off, strict=True))


def paired_axes(
    recording: Recording, axes: Array, accel1: Array, accel2: Array, turning: bool = False
) -> tuple[Array, Pairing]:
    """Return axes (2, 3) with their signs, and what says how these go together.

    The data where they can tell, with the signs as given; else the declared mounts; else nothing, as given. The common
    sign, which means nothing, is that of +y of the segments by the declared mounts. `turning` says that how the
    segments turn has told the signs already.
    """
    told = turning or told_by_data(accel1, accel2, axes)
    if not told and told_by_mounts(recording, axes):
        return toward_y(recording, axes), "from declared mounts"
    signed = axes if along_y(recording, axes).sum() >= 0 else -axes
    return signed, "from data" if told else "unknown"
