"""What is taken out of IMUs on foam, beside the IMUs screwed on: python -m benchmarks.foam_slow RECORDING DIAGNOSIS...

RECORDING is a format 1 folder of `imubench convert diodem --imu nonrigid`, or a part of it (`benchmarks.real` leaves
them below `runs/real`), DIAGNOSIS the folder of `imubench diagnose` for it; both may be given again. Needs
IMUBENCH_DATA.

Both IMUs of a segment turn with it, so the angular rate of the one, turned by one constant rotation, is that of the
other, unless foam gives way between them. What is left below a few Hz is what foam does there. The rotation itself is
read off these rates: what foam does in step with the motion turns it, and with it an axis that it carries from the one
to the other. Without what the diagnosis found it is another one, by as much as foam sags.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.real_axes import SLOW, rigid_axes, rotation_between, source_of
from imubench.arrays import Array
from imubench.band import banded
from imubench.convert import CONVERTERS
from imubench.correction.corrected import corrected
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.solve.subset import cut
from imubench.estimate import Estimate
from imubench.format1 import read_recording
from imubench.paired import paired
from imubench.recording import Imu, Recording
from imubench.run import estimate
from imubench.score import axis_deviation

HEAD = (
    "| recording | readings | apart from the screwed-on IMU, deg/s RMS | rotation differs, deg "
    "| axis by olsson2020, deg: carried by raw rates | by these rates | from the screwed-on IMUs' own estimate |"
)


def apart(one: Imu, other: Imu, hz: float = SLOW) -> tuple[float, Rotation]:
    """Return by how much rates of two IMUs of a body differ below `hz`, rad/s RMS, and the rotation between them."""
    both = banded(Recording("two of one body", "hinge", (replace(one, name="imu1"), replace(other, name="imu2"))), hz)
    rates = paired(both)
    turn = rotation_between(one, other, hz)
    left = rates.gyro2 - turn.apply(np.array(rates.gyro1))
    return float(np.sqrt(np.mean((left - left.mean(axis=0)) ** 2))), turn


def rows(folder: Path, told: Path, rigid: Recording, axes: Array) -> list[str]:
    """Return the table's lines for one recording: as read, and with the findings taken out.

    Args:
        folder: of the recording.
        told: of its diagnosis; one that is doubted is taken at its word here.
        rigid: the screwed-on IMUs of the whole trial.
        axes: theirs (2, 3), as declared.
    """
    raw = read_recording(folder)
    found = replace(read_diagnosis(told), doubts=())
    own = cut(rigid, raw.imus[0].time[0], raw.imus[0].time[-1])
    theirs: Estimate = estimate("olsson2020", own)
    signs = np.sign(np.sum(theirs.value * axes, axis=1, keepdims=True))
    out = []
    whole: list[Rotation] = [rotation_between(a, b) for a, b in zip(own.imus, raw.imus, strict=True)]
    for what, recording in (("as read", raw), ("findings taken out", corrected(raw, found).recording)):
        pairs = [apart(a, b) for a, b in zip(own.imus, recording.imus, strict=True)]
        answer = estimate("olsson2020", recording)
        by_raw, by_these, by_theirs = (
            np.degrees(
                axis_deviation(
                    answer.value, np.stack([r.apply(np.array(a)) for r, a in zip(turns, given, strict=True)])
                )
            )
            for turns, given in (
                (whole, axes),
                ([turn for _, turn in pairs], axes),
                ([turn for _, turn in pairs], signs * theirs.value),
            )
        )
        turned = [np.degrees((turn * before.inv()).magnitude()) for (_, turn), before in zip(pairs, whole, strict=True)]
        off = [np.degrees(left) for left, _ in pairs]
        columns = (_two(off), _two(turned), _two(by_raw), _two(by_these), _two(by_theirs))
        out.append(f"| {'/'.join(folder.parts[-4:-1])} | {what} | {' | '.join(columns)} |")
    return out


def _two(pair: Array | list[float]) -> str:
    return " / ".join(f"{x:.2f}" for x in pair)


def main(words: list[str]) -> None:
    """Print the table."""
    print(HEAD)
    print("|---|---|--:|--:|--:|--:|--:|")
    for folder, told in zip(map(Path, words[::2]), map(Path, words[1::2]), strict=True):
        trial, joint = folder.parts[-4], folder.parts[-3].removesuffix("-foam")
        (rigid,) = CONVERTERS["diodem"](source_of(trial), segments=joint, imu="rigid")
        print("\n".join(rows(folder, told, rigid.recording, rigid_axes(rigid)["declared"])), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
