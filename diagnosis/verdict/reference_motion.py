"""The recovered motion against an independent record of it, which never enters the fit."""

from dataclasses import replace

import numpy as np

from imubench.arrays import Array, rms
from imubench.diagnosis.evidence import Evidence, Played
from imubench.diagnosis.result import Change, Diagnosis
from imubench.reference import Reference
from imubench.rotations import angle_between, conjugate, log, multiply, to_matrix

DIFFERENCE_UNIT = "rad RMS"


def with_reference_errors(d: Diagnosis, evidence: Evidence, reference: Reference | None) -> Diagnosis:
    """Return the diagnosis with how far the nominal and the best model's motion are from a reference."""
    if reference is None:
        return d
    first = evidence.motion if evidence.motion_before is None else evidence.motion_before
    before, after = (motion_errors(motion, reference, evidence.span) for motion in (first, evidence.motion))
    return replace(d, fit=replace(d.fit, reference=Change(before, after, DIFFERENCE_UNIT)))


def motion_errors(motion: Played, reference: Reference, span: tuple[float, float]) -> dict[str, float]:
    """Return RMS errors in rad: of the hinge angle, and of segment 1's orientation but for one constant heading.

    `span` is the recording's first and last stamp: the splines of the motion go on where nothing was measured.
    The hinge angle is given once more without its mean error: no sensor shows where the angle is zero, so a mount
    that is declared to some degrees moves it by as many. The orientation is given once more by its tilt, the angle
    between the verticals as segment 1 sees them: without a magnetometer nothing corrects a heading that drifts.
    """
    out = {}
    inside = (reference.time >= span[0]) & (reference.time <= span[1])
    if reference.hinge_angle is not None and motion.hinge_angle is not None:
        seen = inside & np.isfinite(reference.hinge_angle)
        found = np.interp(reference.time[seen], motion.time, motion.hinge_angle)
        off = angle_difference(found, reference.hinge_angle[seen])
        if seen.any():
            out["hinge_angle"] = rms(off)
            out["hinge_angle_but_constant"] = rms(off - mean_angle(off))
    if reference.quaternion1 is not None:
        seen = inside & np.isfinite(reference.quaternion1).all(axis=1)
        if seen.any():
            found1, measured = quaternions_at(motion, reference.time[seen]), reference.quaternion1[seen]
            out["orientation1"] = rms(off_but_heading(found1, measured))
            out["tilt1"] = rms(angle_between(vertical(found1), vertical(measured)))
    return out


def quaternions_at(motion: Played, time: Array) -> Array:
    """Return segment 1's orientations (n, 4) at times (n,) s."""
    q = np.stack([np.interp(time, motion.time, x) for x in motion.quaternion1.T], axis=1)
    return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))


def vertical(q: Array) -> Array:
    """Return which way is up (n, 3) as segments of orientations q (n, 4) see it."""
    return to_matrix(q)[:, 2]


def off_but_heading(found: Array, measured: Array) -> Array:
    """Return the angles (n,) rad between orientations (n, 4) and measured ones, one heading taken out."""
    between = multiply(measured, conjugate(found))  # found world -> measured world
    heading = heading_of(between)
    back = np.array([np.cos(heading / 2), 0.0, 0.0, -np.sin(heading / 2)])
    return np.linalg.norm(log(multiply(back, between)), axis=1)


def heading_between(measured: Array, found: Array) -> float:
    """Return the angle in rad about the vertical that turns orientations (n, 4) to measured ones (n, 4), on average."""
    return heading_of(multiply(measured, conjugate(found)))


def heading_of(between: Array) -> float:
    """Return the angle in rad about the vertical by which rotations (n, 4) turn on average."""
    return mean_angle(2 * np.arctan2(between[:, 3], between[:, 0]))


def angle_difference(one: Array, other: Array | float) -> Array:
    """Return by how much angles (n,) rad differ, from -pi to pi."""
    return np.asarray(np.remainder(one - other + np.pi, 2 * np.pi) - np.pi)


def mean_angle(x: Array) -> float:
    """Return the circular mean of angles (n,) rad."""
    return float(np.angle(np.mean(np.exp(1j * x))))
