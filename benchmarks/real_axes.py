"""Hinge axes of IMUs on foam beside those of the IMUs screwed on beside them: python -m benchmarks.real_axes [TRIAL]

Needs IMUBENCH_DATA. Both IMUs of a segment turn with it. Below a few Hz, where foam is as good as rigid, they read one
angular rate in two frames: the rotation between them is the one that best turns one into the other (Wahba's problem,
solved by Kabsch's method), and it carries the axis of the screwed-on IMU to the other.
"""

import os
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.table import Row
from imubench import rotations
from imubench.arrays import Array
from imubench.band import banded
from imubench.convert import CONVERTERS
from imubench.convert.converter import Converted
from imubench.diagnosis.solve.subset import cut
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.paired import Paired, paired
from imubench.recording import Imu, Recording
from imubench.reference_axes import HINGE_AXIS, reference_axes
from imubench.run import estimate
from imubench.score import axis_deviation

SLOW = 2.5  # Hz; foam under an IMU rocks at 10 Hz and more, a hand moves mostly below 4
SLOWEST = 0.2  # rad/s, RMS, about the second most excited direction: less does not tell a rotation
JOINTS = ("2-3", "3-4", "4-5")
BANDS = (None, 8.0, 4.0, 3.0, 2.0)
ROWS = {"3-4": (0.3, 1.1), "4-5": (1.6, 3.6)}
"""deg at imu1 and imu2 that `olsson2020` reaches below 3 Hz on trial 1, declared axes carried over: bounds."""
ROUNDED = 0.1  # deg, to which these are stated


def rotation_between(one: Imu, other: Imu, hz: float = SLOW) -> Rotation:
    """Return the rotation from the axes of one IMU to those of another on the same rigid body.

    By their angular rates below `hz` Hz at common times, least squares. Raises `InputError` where they do not turn
    about two directions.
    """
    both = paired(Recording("two of one segment", "hinge", (replace(one, name="imu1"), replace(other, name="imu2"))))
    slow = _below(both, one, other, hz)
    if np.linalg.svd(slow.gyro1, compute_uv=False)[1] < SLOWEST * np.sqrt(len(slow.gyro1)):
        raise InputError(f"{one.name}: expected a segment that turns about two directions, got one")
    return Rotation.align_vectors(slow.gyro2, slow.gyro1)[0]


def _below(both: Paired, one: Imu, other: Imu, hz: float) -> Paired:
    imus = (
        replace(one, name="imu1", time=both.time, gyro=both.gyro1, accel=both.accel1),
        replace(other, name="imu2", time=both.time, gyro=both.gyro2, accel=both.accel2),
    )
    return paired(banded(Recording("two of one segment", "hinge", imus), hz))


def carried_axes(axes: Array, rigid: Recording, foam: Recording) -> Array:
    """Return axes (2, 3) of screwed-on IMUs in the axes of the IMUs on foam beside them."""
    pairs = zip(axes, rigid.imus, foam.imus, strict=True)
    return np.stack([rotation_between(one, other).apply(np.array(axis)) for axis, one, other in pairs])


def rigid_axes(made: Converted) -> dict[str, Array]:
    """Return the hinge axes (2, 3) of screwed-on IMUs as they are declared, and as the optical record has them."""
    declared = np.stack([rotations.rotate_back(imu.mount_quaternion, HINGE_AXIS) for imu in made.recording.imus])
    optical = reference_axes(made.recording, made.reference)
    return {"declared": declared} | ({} if optical is None else {"optical": optical})


def trial(source: Path, joint: str, imu: str) -> tuple[Recording, dict[str, Array]]:
    """Return a recording of a DIODEM trial and its reference axes (2, 3), by the IMUs screwed on."""
    (rigid,), (made,) = (CONVERTERS["diodem"](source, segments=joint, imu=kind) for kind in ("rigid", imu))
    axes = rigid_axes(rigid)
    if imu == "rigid":
        return made.recording, axes
    return made.recording, {name: carried_axes(a, rigid.recording, made.recording) for name, a in axes.items()}


def thirds(recording: Recording) -> list[Recording]:
    """Return the whole recording and its thirds."""
    time = recording.imus[0].time
    edges = np.linspace(time[0], time[-1], 4)
    return [recording, *(cut(recording, a, b) for a, b in pairwise(edges))]


def cells(answer: Estimate, axes: dict[str, Array]) -> str:
    """Return the deviations at imu1 / imu2 in deg from each reference."""
    off = [np.degrees(axis_deviation(answer.value, a)) for a in axes.values()]
    return " | ".join(f"{one:.1f} / {two:.1f}" for one, two in off)


def run() -> list[Row]:
    """Return a row for each joint on foam: what `olsson2020-banded` makes of the raw data of trial 1."""
    rows = []
    for joint, most in ROWS.items():
        recording, axes = trial(source_of("trial1"), joint, "nonrigid")
        answer, peer = estimate("olsson2020-banded", recording), estimate("olsson2020", recording)
        off, other = (np.degrees(axis_deviation(e.value, axes["declared"])) for e in (answer, peer))
        met = answer.status == "converged" and bool(np.all(off <= np.array(most) + ROUNDED / 2))
        what = f"axes of joint {joint} on foam by olsson2020-banded, deg at imu1 / imu2; peer: olsson2020 on all of it"
        figures = (f"{one:.2f} / {two:.2f}" for one, two in (off, other))
        rows.append(Row(what, *figures, "-", f"{most[0]} / {most[1]}, converged", met))
    return rows


def source_of(name: str) -> Path:
    """Return the folder of a DIODEM trial."""
    return Path(os.environ["IMUBENCH_DATA"]) / "diodem" / name


def main(name: str) -> None:
    """Print the table: every joint, screwed on and on foam, whole and in thirds, raw and below each band."""
    print("| joint, IMUs | seconds | estimator | band | status | declared, deg | optical, deg |")
    print("|---|---|---|---|---|---|---|")
    for joint in JOINTS:
        for imu in ("rigid", "nonrigid"):
            recording, axes = trial(source_of(name), joint, imu)
            for part in thirds(recording):
                span = f"{part.imus[0].time[0]:.0f} to {part.imus[0].time[-1]:.0f}"
                answers = [("olsson2020", hz, estimate("olsson2020", part, hz)) for hz in BANDS]
                found = estimate("olsson2020-banded", part)
                for what, hz, answer in (*answers, ("olsson2020-banded", found.details.get("band") or None, found)):
                    band = "all" if hz is None else f"{hz:.3g} Hz"
                    print(f"| {joint}, {imu} | {span} | {what} | {band} | {answer.status} | {cells(answer, axes)} |")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "trial1")
