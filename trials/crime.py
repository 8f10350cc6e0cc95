"""The inverse crime measured: the same questions once more, played by the project's own simulator.

MuJoCo plays the rig (`sim`), the project's own laws put the effects in. Effects, places, strengths, noise levels and
declared facts are those of the generator's case; the motion is one of `sim`'s hand, without rests. What `sim` cannot
do is counted: free swings, physics outside the table, effects of joints and skin, still or very short recordings.
Coloured noise, gaps and repeated samples it does not have: such a case is played with white noise, whole.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from imubench import format1, rotations
from imubench.atomic import MARKER
from imubench.effects import EFFECTS
from imubench.models.tree import rig_tree
from imubench.proof.mixture import Question
from imubench.recording import Encoder, Imu, Pose, Recording
from imubench.sim.imu_model import Declared, DeclaredMount, observe
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.sim.injected import (
    injectable,
    injected_mount,
    injected_profile,
    injected_samples,
)
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.rigs import Mount, Rig, random_hinge, standard_rig
from imubench.sim.signals import Signal, hand
from imubench.trials.figures import figures
from imubench.trials.make import made
from imubench.trials.scoring import CaseScore
from imubench.trials.seal import Truth
from imubench.truth import Truth as World

SUFFIX = "-sim"
ENCODER_STD, POSITION_STD, ROTATION_STD = 5e-4, 1e-3, 4e-3  # rad, m, rad
CORNER, FALLS, FAINT = 2.0, 2.1, 0.4  # Hz up to which a hand turns evenly, its angle's slope and size beyond
BEYOND = 0.5  # s that the motion goes on, for clocks that are late or fast


@dataclass(frozen=True)
class Simulated:
    """One question of the generator, to be played by `sim`."""

    question: Question


def simulates(name: str) -> bool:
    """Return whether an effect needs no more than rigid or sprung mounts in a hand."""
    law = EFFECTS.get(name)
    return law is not None and injectable(name) and not (law.by_hand or law.rolled_out or law.acts("encoder"))


def simulable(question: Question) -> str:
    """Return why `sim` cannot play a question; '' where it can."""
    if question.options.get("swing"):
        return "free swing"
    if question.kind == "outside":
        return "outside the table"
    if not question.observable:
        return "still or very short"
    return ", ".join(name for name, _ in question.effects if not simulates(name))


def twice(asked: Mapping[str, Question]) -> dict[str, Simulated]:
    """Return the questions that `sim` can play, by their names and a suffix."""
    return {name + SUFFIX: Simulated(q) for name, q in asked.items() if not simulable(q)}


def compared(scores: Sequence[CaseScore], again: Sequence[CaseScore]) -> list[dict[str, Any]]:
    """Return every figure over the cases that were played both ways: generator, simulator, their difference."""
    partners = {s.name.removesuffix(SUFFIX) for s in again}
    both = zip(figures([s for s in scores if s.name in partners]), figures(again), strict=True)
    return [
        {
            "name": ours.name,
            "title": ours.title,
            **{f"{who}_{k}": getattr(f, k) for who, f in (("generator", ours), ("sim", other)) for k in ("value", "n")},
            "difference": None if ours.value is None or other.value is None else other.value - ours.value,
        }
        for ours, other in both
    ]


def made_simulated(asked: Simulated, folder: Path) -> Truth:
    """Write the simulator's recording of a question into the new folder and return its truth, that of the generator's.

    Bounds belong to the generator's motion and are left out; strengths are the generator's.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=folder.parent) as scratch:  # removed with the case, should this process be killed
        truth = made(asked.question, Path(scratch) / "recording")
    format1.write_recording(simulated(truth), folder)
    (folder / MARKER).unlink()  # no part of a recording
    truth["bounds"] = [None for _ in truth["effects"]]
    truth["options"] |= {"colour": 0.0, "gaps": 0, "repeats": 0}
    return truth


def simulated(truth: Truth) -> Recording:
    """Return the recording of a truth's effects on a rig and a motion that its seed draws."""
    options, effects = truth["options"], truth["effects"]
    rng, observing = np.random.default_rng([truth["seed"], 1]).spawn(2)
    rig = _rig(options, rng)
    mounts = {f"imu{i + 1}": _declared(m, options, rng) for i, m in enumerate(rig.mounts)}
    placed = [injected_mount(mount, at, mounts[at], effects) for at, mount in zip(mounts, rig.mounts, strict=True)]
    g = next((e["parameters"]["g"] for e in effects if e["effect"] == "gravity"), options["gravity"])
    motion = _hand(options, rng)
    world = play(replace(rig, mounts=tuple(placed), gravity=g), motion, options["seconds"] + BEYOND, threads=1)
    declared = Declared(
        mounts=mounts,
        gravity=options["gravity"],
        base=rig.base,
        base_quaternion=rig.base_quaternion,
        encoders=_encoders(world, options, rng),
        poses=_poses(world, options, rng),
    )
    names = [s.name for s in world.sensors]
    profiles = {n: _profile(n, effects, options, second=k > 0) for k, n in enumerate(names)}
    recording = observe(world, profiles, observing, "recording", declared)
    return replace(recording, imus=tuple(_told(i, effects, options, observing) for i in recording.imus))


def _rig(options: Mapping[str, Any], rng: np.random.Generator) -> Rig:
    if rig_tree(options["rig"]).hinge is None:
        turned = replace(standard_rig(options["rig"]).mounts[0], quaternion=rotations.random(rng))
        return standard_rig(options["rig"], mounts=(turned,))
    base = {"base": "fixed", "base_quaternion": rotations.random(rng)} if options["base"] == "fixed" else {}
    return random_hinge(rng, **base)


def _declared(mount: Mount, options: Mapping[str, Any], rng: np.random.Generator) -> DeclaredMount:
    std = options["position_std"], options["rotation_std"]
    said = std if options["declare_geometry"] else (None, None)
    turn = rotations.exp(std[1] * rng.standard_normal(3))
    position = mount.position + std[0] * rng.standard_normal(3)
    return DeclaredMount(position, rotations.multiply(mount.quaternion, turn), *said)


def _hand(options: Mapping[str, Any], rng: np.random.Generator) -> AngleMotion:
    """Return a motion of the case's band and vigour; a fast hand moves less far.

    As the generator's does, it turns most below `CORNER`, and some up to the band. With all of it at 10 Hz what is
    square in the motion reaches 20, and of 50 samples a second none can tell that from noise.
    """
    band, seconds = options["band"], options["seconds"] + 2 * BEYOND
    slow = min(band, CORNER)
    turn, shift = options["vigour"] / max(slow, 1.0), options["vigour"] / max(slow, 1.0) ** 2

    def signal(std: float, offset: float = 0.0) -> Signal:
        parts = [hand(rng, seconds, std, slow, offset)]
        if band > CORNER:
            parts.append(hand(rng, seconds, FAINT * std * (CORNER / band) ** FALLS, band))
        return lambda time: tuple(np.sum([part(time) for part in parts], axis=0))

    return AngleMotion(
        signal(0.8 * turn), signal(0.4 * turn), signal(0.8 * turn), signal(0.7 * turn, 0.6),
        signal(0.1 * shift), signal(0.1 * shift), signal(0.05 * shift, 1.0),
    )  # fmt: skip


def _profile(at: str, effects: list[dict[str, Any]], options: Mapping[str, Any], second: bool) -> ImuProfile:
    rate = options["rate2"] if second and options["rate2"] else options["rate"]
    gyro, accel = (ChannelProfile(noise_std=options[f"{kind}_noise"]) for kind in ("gyro", "accel"))
    return injected_profile(ImuProfile(at, rate, gyro, accel), at, effects)


def _told(imu: Imu, effects: list[dict[str, Any]], options: Mapping[str, Any], rng: np.random.Generator) -> Imu:
    """Return an IMU with what the effects' laws add to its samples, and with what its owner declares."""
    kept = imu.time <= options["seconds"]
    sampled = replace(imu, time=imu.time[kept], gyro=imu.gyro[kept], accel=imu.accel[kept])
    said = [
        float(f"{options[f'{k}_noise'] * (1 + options['misdeclared']):.3g}") if options["declare_noise"] else None
        for k in ("gyro", "accel")
    ]
    sampled = injected_samples(sampled, effects, rng)
    return replace(sampled, gyro_noise_std=said[0], accel_noise_std=said[1], gyro_range=None, accel_range=None)


def _encoders(world: World, options: Mapping[str, Any], rng: np.random.Generator) -> tuple[Encoder, ...]:
    if not options["encoder"] or world.joint_angle is None:
        return ()
    time = np.arange(0.0, options["seconds"], 1 / options["rate"])
    angle = np.interp(time, world.time, world.joint_angle)
    return (Encoder("hinge", time, angle + ENCODER_STD * rng.standard_normal(time.size), ENCODER_STD),)


def _poses(world: World, options: Mapping[str, Any], rng: np.random.Generator) -> tuple[Pose, ...]:
    wanted = options["pose"] if options["pose"] is not None else rig_tree(options["rig"]).loose
    rows = slice(0, int(options["seconds"] * 1000), 10)  # 100 Hz
    out = []
    for segment in world.segments if wanted else ():
        n = world.time[rows].size
        turn = rotations.exp(ROTATION_STD * rng.standard_normal((n, 3)))
        place = segment.position[rows] + POSITION_STD * rng.standard_normal((n, 3))
        turned = rotations.multiply(segment.quaternion[rows], turn)
        out.append(Pose(segment.name, world.time[rows], place, turned, POSITION_STD, ROTATION_STD))
    return tuple(out)
