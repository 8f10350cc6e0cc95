"""The rig of a diagnosis in 3D: as it was measured or recovered, and in wires as MuJoCo plays both models."""

from dataclasses import replace

import numpy as np
import rerun as rr

from imubench.arrays import Array
from imubench.diagnosis.evidence import Evidence, Played, Posed
from imubench.diagnosis.verdict.estimate_shift import heading_known
from imubench.diagnosis.verdict.reference_motion import heading_between
from imubench.log.scene import AT_REST, Motion, Scene, log_ghost, log_scene, segment_motions
from imubench.log.signals import ESTIMATED, TRUE, drawn_rows
from imubench.recording import Recording
from imubench.reference import Reference
from imubench.rotations import continuous, from_axis_angle, multiply, rotate

SOURCE = "recovered motion"
DECLARED, FOUND = "declared model", "with the findings"


def log_rig(rec: rr.RecordingStream, evidence: Evidence, reference: Reference | None) -> Scene:
    """Log the rig as it was measured, or as its motion was recovered where nothing saw it, and MuJoCo's beside it."""
    recording, rig = evidence.recording, with_fitted_mounts(evidence)
    drawn, source = segment_motions(recording, None, reference)
    if source == AT_REST or len(drawn) < len(recording.tree.names):
        reference, source = as_reference(evidence.motion), SOURCE
        drawn, _ = segment_motions(recording, None, reference)
    scene = log_scene(rec, rig, None, None, reference, None, "")
    models = ((DECLARED, ESTIMATED), (FOUND, TRUE))[-len(evidence.posed) :] if evidence.posed else ()
    for (name, colour), posed in zip(models, evidence.posed, strict=True):
        segments, sensors = laid_on(posed, recording, drawn[recording.tree.names[0]])
        log_ghost(rec, f"world/{name.replace(' ', '_')}", recording.tree, segments, sensors, colour)
    return replace(scene, source=source)


def laid_on(posed: Posed, recording: Recording, drawn: Motion) -> tuple[dict[str, Motion], dict[str, Motion]]:
    """Return a simulated rig in the world of what is drawn.

    A heading that no sensor tells is turned to the drawn one. Where no place is measured, or another than is drawn, the
    first segment's origin is put where it is drawn.

    Args:
        posed: as simulated.
        recording: that it is simulated for.
        drawn: the first segment.

    Returns:
        The segments' and the IMUs' poses in the world, by name.
    """
    rows = drawn_rows(posed.time)
    time = posed.time[rows]
    place, turn = (values[rows] for values in posed.segments[recording.tree.names[0]])
    there, facing = interpolated(drawn, time)
    heading = 0.0 if heading_known(recording) else heading_between(facing, turn)
    yaw = from_axis_angle([0.0, 0.0, 1.0], heading)
    measured = any(pose.position is not None for pose in recording.poses)
    away = np.zeros_like(place) if measured else there - rotate(yaw, place)

    def moved(pose: tuple[Array, Array]) -> Motion:
        return Motion(time, rotate(yaw, pose[0][rows]) + away, multiply(yaw, pose[1][rows]))

    return {n: moved(p) for n, p in posed.segments.items()}, {n: moved(p) for n, p in posed.sensors.items()}


def interpolated(motion: Motion, time: Array) -> tuple[Array, Array]:
    """Return a motion's positions (n, 3) m and quaternions (n, 4) at times (n,) in s, linearly interpolated."""
    turns = continuous(motion.quaternion)
    place, turn = (
        np.stack([np.interp(time, motion.time, x) for x in values.T], axis=1) for values in (motion.position, turns)
    )
    return place, turn / np.linalg.norm(turn, axis=1, keepdims=True)


def with_fitted_mounts(evidence: Evidence) -> Recording:
    """Return the recording with its mounts where the fit has them."""
    imus = [
        replace(imu, mount_position=pose.position, mount_quaternion=pose.quaternion, mount_position_std=0.0)
        for imu in evidence.recording.imus
        if (pose := evidence.mounts[imu.name])
    ]
    return replace(evidence.recording, imus=tuple(imus))


def as_reference(motion: Played) -> Reference:
    """Return a recovered motion in the shape of a record of the segments' poses."""
    second = None
    if motion.hinge_angle is not None:
        second = multiply(motion.quaternion1, from_axis_angle([0.0, 1.0, 0.0], motion.hinge_angle))
    return Reference(motion.time, motion.hinge_angle, motion.quaternion1, second, motion.position)


__all__ = ["DECLARED", "FOUND", "SOURCE", "laid_on", "log_rig"]
