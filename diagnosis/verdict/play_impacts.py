"""Knocks that are a joint's play: a limb that falls from one side of it to the other strikes along one line.

Free to turn by phi about an axis e across the joint's, segment 2 has phi'' (e x r) at an IMU r from the joint's centre.
Play of half a milliradian is over to the other side within two samples: nothing of phi itself is seen, and phi'' is a
knock. What strikes a sensor from outside does so from anywhere. So knocks at the second IMU of a hinge, each with the
direction u of what is above 15 Hz for 0.07 s from its beginning, are called play where the u of all lie on one line (of
the mean of u u' that line has `KNOCK.one_line`) that stands across r. Impacts stay as an equal; of two knocks, which
lie so once in twenty, they are the name and play the equal.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.samples import HIGH_BAND
from imubench.diagnosis.config.shared import CONFIDENCE, EVIDENCE
from imubench.diagnosis.config.verdict import KNOCK
from imubench.diagnosis.result import Finding, Rejected
from imubench.effects import EFFECTS, traits_of
from imubench.effects.traits import Fault
from imubench.recording import Imu, Recording


def impacts_of_play(named: Sequence[Finding], recording: Recording) -> tuple[Finding, ...]:
    """Return the findings, knocks at the second IMU of a hinge called play where they all lie along one line."""
    if recording.tree.hinge is None or len(recording.imus) < 2 or any(traits_of(f.effect).loosens for f in named):
        return tuple(named)
    imu, play = recording.imus[1], EFFECTS.name_of(lambda e: e.loosens)

    def told(f: Finding) -> Finding:
        struck = f.at == imu.name and traits_of(f.effect).fault is Fault.STRUCK
        if not struck or not across(imu, np.atleast_1d(f.parameters["times"].value)):
            return f
        sure = min(f.confidence, CONFIDENCE.free_splines)  # as of any joint that moves without a law
        if f.parameters["times"].value.size < KNOCK.called_play:
            return replace(f, confidence=sure, equivalent=(Rejected(play, "joint", 0.0),))
        return Finding(play, "joint", sure, {}, f.heldout_gain, (Rejected(f.effect, imu.name, 0.0),))

    return tuple(told(f) for f in named)


def across(imu: Imu, times: Array) -> bool:
    """Return whether knocks that begin at `times` (k,) s are all along one line across the sensor's lever arm."""
    lever = rotations.rotate_back(imu.mount_quaternion, imu.mount_position)
    if len(times) < EVIDENCE.events or not np.any(lever):
        return False
    quick = sosfiltfilt(butter(2, HIGH_BAND.pass_hz, "high", fs=imu.rate, output="sos"), imu.accel, axis=0)
    spread = np.zeros((3, 3))
    for start in times:
        u = quick[(imu.time >= start + KNOCK.from_s) & (imu.time <= start + KNOCK.to_s)]
        spread += u.T @ u / np.sum(u**2)
    shares, lines = np.linalg.eigh(spread / len(times))
    return bool(shares[-1] > KNOCK.one_line and abs(lines[:, -1] @ lever) < KNOCK.across_cosine * np.linalg.norm(lever))


__all__ = ["impacts_of_play"]
