"""The hinge axis by `qmt`, the authors' code as ported to Python: a peer, for comparison where it is installed."""

import numpy as np

from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators.extent import too_short
from imubench.estimators.olsson2020 import UNKNOWNS
from imubench.estimators.pairing import paired_axes
from imubench.paired import paired
from imubench.recording import Recording

NAME = "qmt"


def estimate(recording: Recording) -> Estimate:
    """Call `qmt.jointAxisEstHingeOlsson` on all samples with its defaults: no sample selection, start at zero.

    It says nothing of its uncertainty, and nothing when the axis is not identifiable; we refuse too few samples.
    `pairing` says what pairs the signs that it found. The common sign points along +y of the segments, by the declared
    mounts. Raises `InputError` with fewer than two IMUs, or without qmt.
    """
    samples = paired(recording)
    details = {"samples": float(samples.time.size)}
    short = too_short(samples.time, UNKNOWNS)
    if short:
        axes = np.tile([0.0, 1.0, 0.0], (2, 1))
        return Estimate("joint_axis", NAME, axes, None, short, "not identifiable", details=details, pairing="unknown")
    try:
        import qmt
    except ModuleNotFoundError:
        raise InputError("estimator 'qmt': expected the package qmt, got none; pip install 'imubench[peers]'") from None
    arrays = (a.copy() for a in (samples.accel1, samples.accel2, samples.gyro1, samples.gyro2))
    found = qmt.jointAxisEstHingeOlsson(*arrays, {"x0": np.zeros(4), "quiet": True})
    axes = np.stack([np.asarray(axis, dtype=float).ravel() for axis in found[:2]])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    axes, pairing = paired_axes(recording, axes, samples.accel1, samples.accel2)
    return Estimate("joint_axis", NAME, axes, None, "qmt reports none", details=details, pairing=pairing)
