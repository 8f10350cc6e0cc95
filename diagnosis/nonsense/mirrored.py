"""IMUs whose axes are no right-handed ones, or of which gyroscope and accelerometer have different ones.

`handedness` says how the gyroscope's axes lie along the accelerometer's. Several faults may look alike there: a sensor
mirrored in x is one mirrored in z and turned, and the sign of all its forces does not show. Where mounts are declared
each is undone and fitted to the rig; where none of them goes clearly better, all are named.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.nonsense import AXIS_ORDER, STRETCH
from imubench.diagnosis.nonsense.handedness import SIGNED_PERMUTATIONS, Handedness, handedness
from imubench.diagnosis.nonsense.rough_fit import mounts_known, rough_misfit
from imubench.diagnosis.nonsense.stretch import dense_enough, grid, gridded, stretch_of_most_motion
from imubench.diagnosis.result import Nonsense
from imubench.recording import Imu, Recording

AXIS_NAMES = "xyz"
AS_DECLARED = np.eye(3)


@dataclass(frozen=True)
class Fault:
    """One way in which an IMU's axes may be wrong: what it reports is a matrix times what it should."""

    what: str  # after the IMU's name
    gyro: Array  # (3, 3)
    accel: Array  # (3, 3)
    channels: tuple[str, ...]

    def fits(self, way: Array) -> bool:
        """Return whether the gyroscope's axes then lie along the accelerometer's as `way` (3, 3) says.

        Of w_r = G w and f_r = A f with f' = -w x f follows f_r' = -(det(A) A G^T w_r) x f_r.
        """
        return np.allclose(np.linalg.det(self.accel) * self.accel @ self.gyro.T, way)

    def undone(self, imu: Imu) -> Imu:
        """Return the IMU's readings as they should be."""
        return replace(imu, gyro=imu.gyro @ self.gyro, accel=imu.accel @ self.accel)  # inverse of a permutation: its T


def flip(*axes: int) -> Array:
    """Return the matrix that changes the sign of some axes."""
    return np.diag([-1.0 if k in axes else 1.0 for k in range(3)])


def faults() -> Iterator[Fault]:
    """Yield the faults that happen: one sign of one sensor, a left-handed pair, two axes in the wrong order."""
    for k, name in enumerate(AXIS_NAMES):
        gyr, acc = f"gyr_{name}", f"acc_{name}"
        yield Fault(f"'s gyroscope looks mirrored in {name}: {gyr} has the wrong sign", flip(k), AS_DECLARED, (gyr,))
        yield Fault(
            f"'s accelerometer looks mirrored in {name}: {acc} has the wrong sign", AS_DECLARED, flip(k), (acc,)
        )
        both = f" looks mirrored in {name}: {gyr} and {acc} have the wrong sign"
        yield Fault(both, flip(k), flip(k), (gyr, acc))
        one, two = (n for n in AXIS_NAMES if n != name)
        others = [i for i in range(3) if i != k]
        signs = "{}_" + one + " and {}_" + two + " have the wrong sign"
        for part, gyro, accel in (("gyr", flip(*others), AS_DECLARED), ("acc", AS_DECLARED, flip(*others))):
            sensor = "gyroscope" if part == "gyr" else "accelerometer"
            text = f"'s {sensor} looks turned half round about {name}: {signs.format(part, part)}"
            yield Fault(text, gyro, accel, (f"{part}_{one}", f"{part}_{two}"))
        order = list(range(3))
        order[others[0]], order[others[1]] = others[1], others[0]
        swap = np.eye(3)[order]
        channels = tuple(f"{part}_{n}" for part in ("gyr", "acc") for n in (one, two))
        yield Fault(f" looks mirrored: its {one} and {two} axes have changed places", swap, swap, channels)
    every = tuple(f"gyr_{n}" for n in AXIS_NAMES)
    yield Fault("'s gyroscope has the wrong sign on all axes", flip(0, 1, 2), AS_DECLARED, every)


def mirrored(recording: Recording) -> Iterator[Nonsense]:
    """Yield every IMU whose axes cannot be what they are called."""
    some = stretch_of_most_motion(recording, STRETCH.most_s)
    wrong: dict[str, Handedness] = {}
    for imu in some.moving:
        if dense_enough(imu.time) and (edges := grid([imu.time])).size > 1:
            found = handedness(gridded(imu, edges))
            if found is not None and found.wrong:
                wrong[imu.name] = found
    for at, found in wrong.items():
        alike = [name for name, other in wrong.items() if other.best == found.best]
        yield _named(recording, at, found, alike)


def _named(recording: Recording, at: str, found: Handedness, alike: list[str]) -> Nonsense:
    """Return what is wrong with an IMU; the same is wrong with all that are `alike`, it among them."""
    way = SIGNED_PERMUTATIONS[found.best]
    likely = [f for f in faults() if f.fits(way)]
    best = chosen(recording, alike, likely)
    evidence = {"left_m_s": float(found.velocity[0]), "left_with_other_axes_m_s": float(found.velocity[found.best])}
    advice = f"check the signs and the order of {at}'s axes"
    if best is not None:
        return Nonsense(at, at + best.what, evidence, best.channels, advice)
    if np.allclose(way, flip(0, 1, 2)):
        what = f"{at} looks mirrored: its axes are left-handed, or its gyroscope has the wrong sign"
        return Nonsense(at, what, evidence, advice=advice)
    reads = ", ".join(component(row) for row in way.T)
    what = f"{at}'s gyroscope and accelerometer have different axes: one reads ({reads}) where the other has (x, y, z)"
    return Nonsense(at, what, evidence, advice=advice)


def component(row: Array) -> str:
    """Return the axis that a row (3,) of a signed permutation takes: "-y"."""
    k = int(np.argmax(np.abs(row)))
    return ("-" if row[k] < 0 else "") + AXIS_NAMES[k]


def chosen(recording: Recording, alike: list[str], likely: list[Fault]) -> Fault | None:
    """Return the fault of some IMUs without which the recording goes best with its rig: clearly so, or the only one."""
    if len(likely) < 2 or not mounts_known(recording):
        return likely[0] if len(likely) == 1 else None
    misfit = {i: rough_misfit(without(recording, alike, fault)) for i, fault in enumerate(likely)}
    first, second = sorted(misfit, key=lambda i: misfit[i])[:2]
    return likely[first] if misfit[first] < AXIS_ORDER.clearly * misfit[second] else None


def without(recording: Recording, alike: list[str], fault: Fault) -> Recording:
    """Return the recording with a fault of some IMUs undone."""
    return replace(recording, imus=tuple(fault.undone(i) if i.name in alike else i for i in recording.imus))


__all__ = ["mirrored"]
