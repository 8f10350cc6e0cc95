"""The rig that a diagnosis found: fitted mounts, and in MuJoCo's terms what moves or resists at mounts and joint."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.simulation import ROLL_OUT
from imubench.diagnosis.evidence import FittedEffect, Pose
from imubench.diagnosis.result import Finding
from imubench.effects import EFFECTS, VARIANTS
from imubench.effects.effect import Effect
from imubench.recording import Recording
from imubench.sim.rigs import Mount, Rig, Segment, standard_rig


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
    standard, known, tree = standard_rig(recording.rig), numbers_of(findings, fitted), recording.tree
    laws = {(effect, at): law_of(effect, at, fitted) for effect, at in known}
    found = [(at, law, known[name, at]) for (name, at), law in laws.items() if law and law.fits(tree)]
    mounts_now = []
    for imu, usual in zip(tree.imus, standard.mounts, strict=True):
        mount = usual
        if (pose := mounts.get(imu)) is not None:
            mount = Mount(pose.position, pose.quaternion)
            for law, numbers in ((law, numbers) for at, law, numbers in found if at == imu):
                mount = law.on_mount(mount, numbers)
        if recording.body is not None:
            mount = replace(mount, mass=ROLL_OUT.sensor_mass * recording.body.mass)
        mounts_now.append(mount)
    rig = replace(
        standard, mounts=tuple(mounts_now), segments=_segments(recording, standard), gravity=recording.gravity
    )
    if tree.clamps:
        rig = replace(rig, base=recording.base, base_quaternion=recording.base_quaternion)
    for _, law, numbers in found:
        rig = law.on_rig(rig, numbers, recording.body is not None)
    return rig


def law_of(effect: str, at: str, fitted: Sequence[FittedEffect]) -> Effect | None:
    """Return an effect of the library in the variant that was fitted at a place; None of what is none."""
    variant = next((f.variant for f in fitted if (f.effect, f.at) == (effect, at)), "")
    return next((e for e in VARIANTS if (e.name, e.variant) == (effect, variant)), EFFECTS.get(effect))


def numbers_of(findings: Iterable[Finding], fitted: Sequence[FittedEffect]) -> dict[tuple[str, str], dict[str, Array]]:
    """Return the numbers of every named finding by effect and place: those reported, and beside them those fitted."""
    known: dict[tuple[str, str], dict[str, Array]] = {}
    for f in findings:
        told = [dict(own.values) for own in fitted if (own.effect, own.at) == (f.effect, f.at)]
        known[f.effect, f.at] = (told[0] if told else {}) | {name: p.value for name, p in f.parameters.items()}
    return known


def _segments(recording: Recording, standard: Rig) -> tuple[Segment, ...]:
    """Return the rig's segments, the swinging one as it is declared."""
    body = recording.body
    if body is None:
        return standard.segments
    return (*standard.segments[:-1], Segment(body.mass, body.com, possible_moments(body.inertia)))


def possible_moments(inertia: Array) -> Array:
    """Return moments of inertia (3,) kg m^2 that a body can have: none is more than the sum of the others.

    Measured ones of a slender body may miss that by their errors. The greatest stays, which a swing across the body
    shows; both others grow by half of what they lack.
    """
    lacking = 2 * float(inertia.max()) - float(inertia.sum())
    if lacking <= 0:
        return inertia
    return np.asarray(inertia + np.where(np.arange(3) == inertia.argmax(), 0.0, lacking / 2))


__all__ = ["law_of", "numbers_of", "possible_moments", "rig_of"]
