"""A mount that is found turned as if the sensor's axes were called by each other's names."""

from collections.abc import Iterable

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.nonsense import AXIS_ORDER
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.nonsense.handedness import SIGNED_PERMUTATIONS
from imubench.diagnosis.nonsense.mirrored import component
from imubench.diagnosis.problem.rig_kinematics import HINGE_AXIS
from imubench.diagnosis.result import Finding, Nonsense
from imubench.effects import traits_of
from imubench.recording import Imu, Recording
from imubench.rotations import exp, to_matrix


def permuted(findings: Iterable[Finding], recording: Recording) -> tuple[Nonsense, ...]:
    """Return the IMUs whose found mount is what a change of their axes' names and signs would make of the declared one.

    On a hinge only the hinge's axis in the sensor is held against it: a turn about that is the joint's own. A pendulum
    and a lone body show no turn of their sensor at all, but for what a measured pose tells.
    """
    out = []
    for f in findings:
        if not traits_of(f.effect).misplaces or f.confidence < CONFIDENCE.counts or recording.tree.ball is not None:
            continue
        way = way_of(f, recording.imu(f.at), recording.tree.hinge is not None)
        if way is not None:
            reads = ", ".join(component(row) for row in way)
            what = f"{f.at}'s axes look permuted: it reads ({reads}) where the model has (x, y, z)"
            out.append(Nonsense(f.at, what, advice=f"check the order of {f.at}'s axes, or declare the mount as it is"))
    return tuple(out)


def way_of(f: Finding, imu: Imu, hinge: bool) -> Array | None:
    """Return the signed permutation (3, 3) without a mirror that a mount pose is nearest to, if it is one.

    With the declared mount D and the found D R the sensor reads R' of what it should.
    """
    turn, std = f.parameters["rotation"].value, f.parameters["rotation"].std
    found = to_matrix(exp(turn)).T
    if np.linalg.norm(turn) < AXIS_ORDER.turned_rad:
        return None
    near = AXIS_ORDER.near_rad + 3 * float(np.max(std))
    axis = to_matrix(imu.mount_quaternion)[HINGE_AXIS]  # of the segment, in axes of the sensor as declared
    best, least = None, near
    for way in SIGNED_PERMUTATIONS[1:]:
        if np.linalg.det(way) < 0 or (hinge and way @ axis @ axis > np.cos(AXIS_ORDER.turned_rad)):
            continue  # nearly the axis that is declared: nothing would have changed
        off = float(np.arccos(np.clip(found @ axis @ (way @ axis), -1, 1))) if hinge else angle(found @ way.T)
        if off < least:
            best, least = way, off
    return best


def angle(turn: Array) -> float:
    """Return the angle in rad of a rotation (3, 3)."""
    return float(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)))


__all__ = ["permuted"]
