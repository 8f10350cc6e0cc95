"""The rig that a diagnosis found: fitted mounts, and in MuJoCo's terms what moves or resists at mounts and joint."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.correction import REPLAY
from imubench.diagnosis.evidence import FittedEffect, Pose
from imubench.diagnosis.result import Finding
from imubench.effects import EFFECTS
from imubench.errors import InputError
from imubench.recording import Recording
from imubench.sim.joints import Play, Stop
from imubench.sim.rigs import HEAVIEST, STANDARD_RIGS, Mount, Rig, Segment, Slip, springs

SPRINGY = "springy"
Numbers = Mapping[str, Array]


def rig_of(
    recording: Recording,
    mounts: Mapping[str, Pose],
    findings: Iterable[Finding] = (),
    fitted: Sequence[FittedEffect] = (),
) -> Rig:
    """Return the rig that MuJoCo plays: fitted mounts, and what of the findings belongs to mounts, joint and world.

    Where the recording has no IMU the rig has its usual one.

    Args:
        recording: what it declares.
        mounts: by IMU, before what an effect moves.
        findings: with the numbers that a report names.
        fitted: the same effects with all their numbers; what neither tells is as the law's prior has it.
    """
    standard, known = STANDARD_RIGS[recording.rig](), numbers_of(findings, fitted)
    variants = {(f.effect, f.at): f.variant for f in fitted}
    named = {f"imu{i + 1}": mount for i, mount in enumerate(standard.mounts)}
    changes: dict[str, Any] = {
        "mounts": tuple(
            mount_of(mounts[imu], {name: values for (name, at), values in known.items() if at == imu})
            if imu in mounts
            else usual
            for imu, usual in named.items()
        ),
        "segments": _segments(recording, standard),
        "gravity": float(known.get(("gravity", "world"), {}).get("g", recording.gravity)),
    }
    if recording.body is not None:
        changes["mounts"] = tuple(replace(m, mass=REPLAY.sensor_mass * recording.body.mass) for m in changes["mounts"])
    at_joint = {name: values for (name, at), values in known.items() if at in ("joint", "body")}
    if recording.rig != "free":
        changes |= _torques(at_joint) | {"spring_conserves": variants.get(("joint_spring", "joint")) == "conservative"}
    if recording.rig == "pendulum":
        changes["pivot_moves"] = "moving_pivot" in at_joint
    if recording.rig == "hinge":
        changes |= {"base": recording.base, "base_quaternion": recording.base_quaternion}
        changes |= _hinge(at_joint, variants.get(("joint_play", "joint"), ""), recording, changes["segments"])
    return replace(standard, **changes)


def numbers_of(findings: Iterable[Finding], fitted: Sequence[FittedEffect]) -> dict[tuple[str, str], dict[str, Array]]:
    """Return the numbers of every named finding by effect and place: those reported, and beside them those fitted."""
    known: dict[tuple[str, str], dict[str, Array]] = {}
    for f in findings:
        told = [dict(own.values) for own in fitted if (own.effect, own.at) == (f.effect, f.at)]
        known[f.effect, f.at] = (told[0] if told else {}) | {name: p.value for name, p in f.parameters.items()}
    return known


def _torques(known: Mapping[str, Numbers]) -> dict[str, Any]:
    """Return what resists at a joint, and how light its body is, as numbers of a rig."""

    def number(effect: str, key: str) -> float:
        return float(known.get(effect, {}).get(key, 0.0))

    found: dict[str, Any] = {
        "damping": max(number("viscous_friction", "c"), 0.0),  # a fit may go a little below nothing
        "dry_friction": max(number("dry_friction", "t"), 0.0),
        "drag": max(number("air_drag", "d"), 0.0),
        "stiffness": number("joint_spring", "k"),
        "spring_angle": number("joint_spring", "q0"),
    }
    if "end_stop" in known:
        told = {
            key: float(known["end_stop"].get(key, usual_start(("end_stop", key)))) for key in ("stiffness", "damping")
        }
        found["stop"] = Stop(float(known["end_stop"]["angle"]), **told)
    if "inertia" in known:
        found["inertia_scale"] = float(known["inertia"]["scale"])
    return found


def usual_start(key: tuple[str, str]) -> float:
    """Return where a fit of an effect's number begins: what stands for one that nobody tells."""
    effect, name = key
    return float(next(p.start for p in EFFECTS[effect].parameters if p.name == name))  # type: ignore[arg-type]


def _hinge(
    known: Mapping[str, Numbers], variant: str, recording: Recording, segments: Sequence[Segment]
) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if "axis_coupling" in known:
        found["coupling"] = known["axis_coupling"]["coupling"]
    if "moving_centre" in known:
        found["centre"] = known["moving_centre"]["slide"]
    if "joint_play" in known:
        found["play"] = play_of(known["joint_play"], variant)
        if recording.body is None and "arm" in known["joint_play"]:
            found["segments"] = (*segments[:-1], _loose(segments[-1], found["play"], known["joint_play"]["arm"]))
    return found


def play_of(numbers: Numbers, variant: str) -> Play:
    """Return a play with a finding's numbers; on springs where it was found on such.

    A share above 1 no inertia has: it is taken as 1.
    """
    reach, direction = max(float(numbers.get("range", 0.0)), 1e-6), float(numbers.get("direction", 0.0))
    if variant != SPRINGY or "frequency" not in numbers:
        return Play(reach, direction)
    share = min(float(numbers.get("share", 1.0)), 1.0)
    # Springs of which nothing beyond a range was seen have no stops there: these would come on top of what was fitted.
    frequency, ratio = float(numbers["frequency"]), float(numbers["damping_ratio"])
    return Play(REPLAY.stop_range * reach, direction, frequency, ratio, share)


def _loose(segment: Segment, play: Play, arm: Array) -> Segment:
    """Return the segment whose play has the load -e . (w' + arm x f), in units of its inertia about e.

    With c across e and the same inertia I0 about every axis through the com, I0 + m c^2 = m k^2 about e, arm = c / k^2.
    What is of second order, e . (w x I w), is (c / k)^2 of that and not in the law: c / k is made small.
    """
    across = arm - play.axis * (play.axis @ arm)
    size = max(float(np.linalg.norm(across)), 1e-3)
    k = REPLAY.off_axis / size
    com = k**2 * across
    return Segment(segment.mass, com, np.full(3, segment.mass * (k**2 - com @ com)), segment.length)


def mount_of(pose: Pose, found: Mapping[str, Numbers]) -> Mount:
    """Return a mount at a fitted pose with what was found of it: moved, on springs, slipped, sliding."""
    moved, soft, rocking = (found.get(name) for name in ("mount_pose", "soft_mount", "rocking_mount"))
    position, quaternion = pose.position, pose.quaternion
    if moved is not None:
        position = position + moved["translation"]
        quaternion = rotations.multiply(quaternion, rotations.exp(moved["rotation"]))
    mount = Mount(position, quaternion)
    if soft is not None:
        mount = replace(mount, translation=springs(soft["frequency"], soft["damping_ratio"]))
    if rocking is not None:
        com = rocking.get("com", np.zeros(3))
        gyration = float(rocking.get("gyration", mount.gyration))
        # Only com / gyration^2 shows, and a body that turns about every axis alike is no heavier on one side than so.
        smaller = min(1.0, 0.99 * HEAVIEST * gyration / max(float(np.linalg.norm(com)), 1e-12))
        mount = replace(
            mount,
            rotation=springs(rocking["frequency"], rocking["damping_ratio"]),
            com=com * smaller**2,
            gyration=gyration * smaller,
            lever=rocking.get("lever", np.zeros(3)),
        )
    if (shift := found.get("mount_shift")) is not None:
        mount = replace(mount, slip=Slip(float(shift["time"]), shift["translation"], shift["rotation"]))
    if (skin := found.get("skin_sliding")) is not None:
        mount = replace(mount, slide=skin["slide"], twist=skin["twist"])
    return mount


def _segments(recording: Recording, standard: Rig) -> tuple[Segment, ...]:
    """Return the rig's segments, the swinging one as it is declared, where a body can be like that."""
    if recording.body is None:
        return standard.segments
    body = recording.body
    try:
        return (*standard.segments[:-1], Segment(body.mass, body.com, body.inertia))
    except InputError:
        return standard.segments


__all__ = ["mount_of", "numbers_of", "play_of", "rig_of"]
