"""A rig's joints and its swinging body in MuJoCo's terms: friction, springs, stops, gears, play."""

from typing import Any

import mujoco
import numpy as np

from imubench import rotations
from imubench.models.tree import Tree
from imubench.sim.joints import IMPEDANCE, KNOCK_FREQUENCY, KNOCK_RATIO, Play
from imubench.sim.rigs import Rig, inertia_about

PLAY = "play"
"""The joint of a loose limb, across the hinge's axis."""
TOLD_PLAY = ("told_play", "told_play_beside")
"""The two of a limb whose play is told."""
TINY_ARMATURE = 1e-7  # kg m^2 or kg, of what is geared: a ten-thousandth of a small limb's
NO_WEIGHT = 1e-12  # of a body's weight
FAR = 100.0  # rad: where a joint with a stop on one side has its other one


def along(vector: np.ndarray) -> np.ndarray:
    """Return an axis along a vector (3,), however short that is: MuJoCo takes none of under 1e-14."""
    return vector / np.abs(vector).max()


def lighten(body: Any, scale: float) -> None:
    """Give a body m l / I of so many times its own, its weight unchanged: mass and inertia / scale, heavier by gravity.

    MuJoCo's `gravcomp` c takes c m g off a body's weight: m / scale (1 - c) g = m g for c = 1 - scale. It looks for it
    only where some body has a positive one, so another one gets one of no weight.
    """
    if scale != 1.0:
        body.mass, body.inertia, body.gravcomp = body.mass / scale, np.asarray(body.inertia) / scale, 1.0 - scale
        other = body.first_body() or body.parent  # of segment 2 without an IMU
        other.gravcomp = NO_WEIGHT


def set_joint(spec: Any, rig: Rig) -> None:
    """Give a model's joint what a rig says of it: how its base is held, what resists, what it does beside turning."""
    tree = rig.tree
    if rig.clamped and tree.base is not None:
        spec.delete(spec.joint(tree.base.name))
        spec.body(tree.names[0]).quat = rig.base_quaternion
    if rig.pivot_moves and tree.ball is not None:
        _carry(spec, tree, tree.ball.name)
    if tree.joint is None:
        return
    joint = spec.joint(tree.joint.name)
    if rig.centre.any():
        joint = _slide_before(spec, tree, joint, rig.centre)
    joint.damping[0], joint.damping[1] = rig.damping, rig.drag
    if tree.hinge is not None:
        joint.stiffness[0] = rig.stiffness
        joint.springref = _degrees(spec, rig.spring_angle)
    joint.frictionloss = rig.dry_friction
    joint.solref_friction = [
        2 * spec.option.timestep,
        1.0,
    ]  # turns over as fast as a step allows: MuJoCo's own is 20 ms
    if rig.locked_at is not None:
        spec.delete(joint)
        spec.body(tree.last.name).quat = rotations.exp(np.array([0.0, rig.locked_at, 0.0]))
        return
    if rig.stop is not None and tree.hinge is not None:
        ends = (rig.stop.angle, FAR) if rig.stop.side < 0 else (-FAR, rig.stop.angle)
        _limit(spec, joint, ends, rig.stop.stiffness, rig.stop.damping)
    for axis, letter, c in zip(np.eye(3)[[0, 2]], "xz", rig.coupling, strict=True):
        if rig.coupling.any():
            _geared(spec, tree, f"coupling_{letter}", mujoco.mjtJoint.mjJNT_HINGE, axis, float(c))
    if rig.loose is not None:
        _loosen(spec, rig, rig.loose)
    elif rig.play is not None:
        for name, axis in zip(TOLD_PLAY, (rig.play.axis, rig.play.beside), strict=True):
            spec.body(tree.last.name).add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)


def _degrees(spec: Any, angle: float) -> float:
    return float(np.rad2deg(angle)) if spec.compiler.degree else angle


def _slide_before(spec: Any, tree: Tree, joint: Any, centre: np.ndarray) -> Any:
    """Put a slide before the hinge, geared to it, and return the hinge, made anew behind that."""
    name, axis = joint.name, list(joint.axis)
    spec.delete(joint)
    body = spec.body(tree.last.name)
    body.add_joint(name="centre", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=along(centre))
    hinge = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
    gear(spec, tree, "centre", float(np.linalg.norm(centre)))
    return hinge


def _geared(spec: Any, tree: Tree, name: str, kind: Any, axis: np.ndarray, ratio: float) -> None:
    """Add a joint to segment 2 that follows the hinge; three turns about axes in a row need some inertia each."""
    spec.body(tree.last.name).add_joint(name=name, type=kind, axis=axis, armature=TINY_ARMATURE)
    gear(spec, tree, name, ratio)


def gear(spec: Any, tree: Tree, name: str, ratio: float) -> None:
    """Let a joint be `ratio` times the hinge's angle, as an equality."""
    assert tree.hinge is not None
    spec.add_equality(
        name=name,
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=name,
        name2=tree.hinge.name,
        data=[0.0, ratio, *[0.0] * 10],
        solref=[2 * spec.option.timestep, 1.0],
    )


def _limit(spec: Any, joint: Any, ends: tuple[float, float], stiffness: float, damping: float) -> None:
    """Let a joint meet a one-sided spring and damper beyond its range, both by its inverse inertia."""
    joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    joint.range = [_degrees(spec, end) for end in ends]
    joint.solref_limit = [-stiffness, -damping]
    joint.solimp_limit = [IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0]


def _loosen(spec: Any, rig: Rig, play: Play) -> None:
    """Add the joint of a play to segment 2, between stops, on springs where it has them.

    Its armature is the load's share that hands bear: (J + armature) phi'' = load, share = J / (J + armature).
    """
    joint = spec.body(rig.tree.last.name).add_joint(name=PLAY, type=mujoco.mjtJoint.mjJNT_HINGE, axis=play.axis)
    own = loose_inertia(rig)
    whole, w = own / play.share, 2 * np.pi * play.frequency
    joint.armature = whole - own
    joint.stiffness[0], joint.damping[0] = whole * w**2, whole * 2 * play.damping_ratio * w
    w = 2 * np.pi * KNOCK_FREQUENCY
    _limit(spec, joint, (-play.range, play.range), w**2, 2 * KNOCK_RATIO * w)


def loose_inertia(rig: Rig) -> float:
    """Return the inertia of segment 2 about the axis of its play, kg m^2, through the joint."""
    assert rig.play is not None
    return inertia_about(rig, rig.play.axis)


def _carry(spec: Any, tree: Tree, ball: str) -> None:
    """Put slides along the world's axes before a ball joint."""
    spec.delete(spec.joint(ball))
    body = spec.body(tree.last.name)
    for axis, letter in zip(np.eye(3), "xyz", strict=True):
        body.add_joint(name=f"pivot_{letter}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    body.add_joint(name=ball, type=mujoco.mjtJoint.mjJNT_BALL)


__all__ = ["PLAY", "TINY_ARMATURE", "TOLD_PLAY", "gear", "lighten", "loose_inertia", "set_joint"]
