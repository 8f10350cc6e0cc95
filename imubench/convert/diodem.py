"""A hand-moved chain of five printed segments with an optical reference, in DIODEM's CSV layout.

Source: supplementary material of RING, related to DIODEM (doi 10.7910/DVN/SGJLZA).

The chain is 1 -ball- 2 -hinge x- 3 -hinge y- 4 -hinge z- 5; +x of every segment frame of the dataset runs
along the stretched chain, from segment 1 to 5, and at joint angle 0 the two frames beside a joint coincide.
`FRAMES` turns these frames into ours (hinge axis +y, segment 1 along -x, segment 2 along +x).
"""

import re
from pathlib import Path

import numpy as np

from imubench.alignment import check_z_up, gyro_delay
from imubench.arrays import Array
from imubench.convert.converter import Converted, Converter, Option, choice, number
from imubench.convert.table import read_columns, read_lines, stack
from imubench.errors import InputError
from imubench.inputs.files import real
from imubench.recording import Imu, Recording
from imubench.reference import Reference
from imubench.rotations import conjugate, log, multiply
from imubench.timing import on_imu_clock

HALF = float(np.sqrt(0.5))
FRAMES: dict[str, tuple[float, float, float, float]] = {
    "2-3": (HALF, 0.0, 0.0, HALF),  # hinge x -> y, y -> -x, z kept: the hinge turns about the chain itself,
    #                                 so this chain runs along our y; no frame can put it along x
    "3-4": (1.0, 0.0, 0.0, 0.0),  # hinge y and chain x are ours already
    "4-5": (HALF, -HALF, 0.0, 0.0),  # hinge z -> y, y -> -z, x kept
}
"""For each joint the quaternion (dataset's segment frame -> ours), the same for both segments."""

MOUNT_ROTATION_STD = {"rigid": 0.02, "nonrigid": 0.15}
"""rad, what the owner of such a chain would declare, and not what any trial shows: a printed socket holds its IMU to
about a degree; foam of a centimetre that gives way by a millimetre or two leans by some 9 deg."""
SEGMENTS = (1, 2, 3, 4, 5)


def parse_segments(text: str) -> object:
    """Return a name of `FRAMES`; `InputError` says why the ball joint is none."""
    if text == "1-2":
        raise InputError(f"segments '1-2': expected a hinge, got the chain's ball joint; known: {', '.join(FRAMES)}")
    return choice("segments", tuple(FRAMES))(text)


def convert(
    source: Path, segments: str = "3-4", imu: str = "rigid", optical_delay: float | None = None
) -> list[Converted]:
    """Return one joint of one trial: imu1 and imu2 on the named segments, the optical record as reference.

    `source` is a trial's folder with imu_rigid.csv, imu_nonrigid.csv and omc.csv. The reference's stamps are those of
    the IMUs' clock: k / rate less the delay that the five IMUs of the set show (`optical_timing`), or the given one.
    """
    beside = [int(s) for s in segments.split("-")]
    to_ours = np.array(FRAMES[segments])
    signals, rate = _read_imus(source / f"imu_{imu}.csv")
    time, quaternions, filled = _read_optical(source / "omc.csv")
    stamps, timed = on_imu_clock(
        [(_imu(f"segment {s}", signals[s], rate), time, quaternions[s - 1]) for s in SEGMENTS], time, optical_delay
    )
    imus = tuple(_imu(f"imu{i + 1}", signals[s], rate, to_ours, MOUNT_ROTATION_STD[imu]) for i, s in enumerate(beside))
    q1, q2 = (multiply(quaternions[s - 1], conjugate(to_ours)) for s in beside)
    angle, off_axis = hinge_angle(q1, q2)
    notes = [
        f"Joint {segments} with {imu} IMUs, RING supplementary material related to DIODEM "
        "(doi 10.7910/DVN/SGJLZA); its licence is not stated: cite, do not redistribute.",
        f"Dataset's segment frame -> ours: quaternion {np.round(to_ours, 4).tolist()}; mount positions unknown, "
        f"rotations declared to {MOUNT_ROTATION_STD[imu]:g} rad, a belief about such mounts.",
        f"{timed} {filled} gap-filled frames left out.",
        f"Optical motion off the hinge axis {np.rad2deg(off_axis):.2f} deg RMS.",
    ]
    for one, q in zip(imus, (q1, q2), strict=True):
        tilt = check_z_up(one, stamps, q)
        delay, misfit = gyro_delay(one, stamps, q)
        notes.append(
            f"{one.name}: specific force {np.rad2deg(tilt):.1f} deg from the optical z on average, gyroscope "
            f"{delay * 1e3:+.1f} ms late against the reference, |rate| misfit {np.rad2deg(misfit):.1f} deg/s RMS."
        )
    recording = Recording(name=f"diodem-{real(source).name}-{segments}-{imu}", rig="hinge", imus=imus)
    reference = Reference(time=stamps, hinge_angle=angle, quaternion1=q1, quaternion2=q2)
    return [Converted(recording, reference, " ".join(notes))]


def hinge_angle(q1: Array, q2: Array) -> tuple[Array, float]:
    """Return the twist (n,) rad of segment 2 against 1 about +y, NaN where unseen, and the RMS rotation off it, rad.

    `q1`, `q2` (n, 4) segment -> world. The rest is taken as R(twist)^-1 after the relative rotation.
    """
    relative = multiply(conjugate(q1), q2)
    relative = np.where(relative[:, :1] < 0, -relative, relative)
    angle = 2 * np.arctan2(relative[:, 2], relative[:, 0])
    zero = np.zeros_like(angle)
    twist = np.stack([np.cos(angle / 2), zero, np.sin(angle / 2), zero], axis=-1)
    rest = log(multiply(relative, conjugate(twist)))
    return angle, float(np.sqrt(np.nanmean(np.sum(rest**2, axis=-1))))


def _read_imus(path: Path) -> tuple[dict[int, tuple[Array, Array]], float]:
    """Return gyro (n, 3) rad/s and accel (n, 3) m/s^2 of the IMU on each segment, and their rate in Hz."""
    rate = _read_rate(path)
    names = {s: [[f"seg{s}_{kind}_{c}" for c in "xyz"] for kind in ("gyr", "acc")] for s in SEGMENTS}
    table = read_columns(path, [c for kinds in names.values() for kind in kinds for c in kind], header_line=2)
    return {s: (stack(table, gyro), stack(table, accel)) for s, (gyro, accel) in names.items()}, rate


def _imu(
    name: str,
    signals: tuple[Array, Array],
    rate: float,
    mount: Array | None = None,
    rotation_std: float | None = None,
) -> Imu:
    gyro, accel = signals
    known = {} if mount is None else {"mount_quaternion": mount}
    return Imu(name, np.arange(len(gyro)) / rate, gyro, accel, rate, **known, mount_rotation_std=rotation_std)  # type: ignore[arg-type]


def _read_optical(path: Path) -> tuple[Array, Array, int]:
    """Return the stamps (n,) s, quaternions (5, n, 4) segment -> earth, and how many gap-filled frames were blanked.

    Where the cameras lost the chain, four segments are NaN but segment 4 was filled in (its markers then leave
    their rigid shape by millimetres): a frame without the four others counts as unseen.
    """
    rate = _read_rate(path)
    names = [[f"seg{s}_quat_{c}" for c in "wxyz"] for s in range(1, 6)]
    table = read_columns(path, [c for segment in names for c in segment], header_line=2, gaps=True)
    quaternions = np.stack([stack(table, segment) for segment in names])
    seen = np.isfinite(quaternions).all(axis=-1)
    filled = seen & (seen.sum(axis=0) == 1)
    quaternions[filled] = np.nan
    quaternions /= np.linalg.norm(quaternions, axis=-1, keepdims=True)
    return np.arange(seen.shape[1]) / rate, quaternions, int(filled.sum())


def _read_rate(path: Path) -> float:
    """Return the rate in Hz from a file's first line, after a look at the units on its second."""
    rate_line, units_line = read_lines(path, 2)
    rate = re.fullmatch(r"#\s*sampling frequency:\s*([0-9.]+)\s*", rate_line)
    if rate is None or not float(rate[1]) > 0:
        raise InputError(f"{path}, line 1: expected '# sampling frequency: RATE', got '{rate_line[:60]}'")
    if "seconds/meters/radians" not in units_line:
        raise InputError(
            f"{path}, line 2: expected units seconds/meters/radians, got '{units_line.removeprefix('#').strip()[:60]}'"
        )
    return float(rate[1])


CONVERTER = Converter(
    "diodem",
    "a trial's folder of the DIODEM chain: two IMUs beside one hinge, optical reference",
    convert,
    {
        "segments": Option(
            "the two segments beside the joint: 3-4, 4-5, or 2-3 (turns about the chain itself)", parse_segments
        ),
        "imu": Option("rigid (screwed on) or nonrigid (on foam)", choice("imu", tuple(MOUNT_ROTATION_STD))),
        "optical_delay": Option(
            "s by which the optical stamps are late; not given: what the gyroscopes show", number("optical_delay")
        ),
    },
)
