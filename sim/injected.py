"""Named effects put into a simulation: on the mounts and the joint, into the IMU profiles, on the samples.

An effect is {"effect": a name of `effects.EFFECTS`, "at": a sensor or another place, "parameters": {name: value}}. What
is not for the sensor that is asked about is passed over. What an IMU model has a number for goes into its profile; all
else acts by what the effect itself says: `injected_mount`, `injected_rig`, `error`, `corrupt`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from imubench.effects import EFFECTS
from imubench.effects.effect import Effect, Reading
from imubench.jets import Jet
from imubench.recording import Body, Imu
from imubench.sim.imu_model import DeclaredMount
from imubench.sim.imu_profile import ImuProfile
from imubench.sim.motion import Carried, Motion
from imubench.sim.rigs import Mount, Rig, Segment
from imubench.sim.signals import Sines

Injected = Mapping[str, Any]  # {"effect", "at", "parameters"}

SUMMED = {  # effect -> field of a channel's profile, by its parameter: the effect comes on top
    **{f"{kind}_bias": ("bias", "bias") for kind in ("gyro", "accel")},
    **{f"{kind}_scale": ("scale", "scale") for kind in ("gyro", "accel")},
    **{f"{kind}_misalignment": ("misalignment", "matrix") for kind in ("gyro", "accel")},
}
NOISE = {f"{kind}_noise": ("noise_std", "std") for kind in ("gyro", "accel")}  # the effect is the total
DIGITAL = {"low_pass": ("bandwidth", "cutoff"), "saturation": ("range", "limit"), "quantisation": ("step", "step")}
IN_PROFILE = (*SUMMED, *NOISE, *DIGITAL, "g_sensitivity", "time_offset", "clock_skew", "dropouts")
"""The effects that an IMU model has a number for."""
LINES = 30  # sines of a moving pivot, along each axis


def injectable(name: str) -> bool:
    """Return whether an effect can be played: whether a profile has it, or it says itself what it does."""
    law = EFFECTS.get(name)
    if law is None:
        return False
    return name in IN_PROFILE or law.in_the_rig or law.acts("error", "corrupt", "encoder", "lighter")


def all_injectable() -> tuple[str, ...]:
    """Return the names of the effects that can be played."""
    return tuple(filter(injectable, EFFECTS))


def rolled_out(name: str) -> bool:
    """Return whether an effect shows in free swings alone."""
    law = EFFECTS.get(name)
    return law is not None and law.rolled_out


def _laws(effects: Sequence[Injected], at: str | None = None) -> list[tuple[Effect, Mapping[str, Any]]]:
    """Return the laws of effects, at a place if one is given, with their parameters."""
    return [(EFFECTS[e["effect"]], e["parameters"]) for e in effects if at in (None, e["at"])]


def injected_mount(mount: Mount, at: str, declared: DeclaredMount, effects: Sequence[Injected]) -> Mount:
    """Return the mount of the sensor `at` with its effects in it.

    Where an effect says how far the sensor is from where it is declared, it is so far from there.
    """
    for law, parameters in _laws(effects, at):
        if law.misplaces:
            mount = replace(mount, position=declared.position, quaternion=declared.quaternion)
        mount = law.injected_mount(mount, parameters)
    return mount


def injected_rig(rig: Rig, declared: Mapping[str, DeclaredMount], effects: Sequence[Injected]) -> Rig:
    """Return the rig with its effects in it: its mounts, its joint, the world's gravity.

    Args:
        rig: as its owner believes it.
        declared: by sensor, where its owner believes the mounts.
        effects: those of other places than a rig are passed over, and so is a pivot that moves, see `carried`.
    """
    mounts = [injected_mount(m, at, declared[at], effects) for at, m in mounts_of(rig).items()]
    rig = replace(rig, mounts=tuple(mounts))
    for law, parameters in _laws(effects):
        rig = law.injected_rig(rig, parameters)
    return rig


def sprung_mount(mount: Mount, at: str, effects: Sequence[Injected]) -> Mount:
    """Return the mount of the sensor `at` on the springs of its effects."""
    for law, parameters in _laws(effects, at):
        mount = law.injected_mount(mount, parameters) if law.on_springs else mount
    return mount


def mounts_of(rig: Rig) -> dict[str, Mount]:
    """Return a rig's mounts by their sensor."""
    return dict(zip(rig.tree.imus, rig.mounts, strict=False))  # the first IMUs have one


def carried(motion: Motion, rig: Rig, effects: Sequence[Injected], rng: np.random.Generator) -> tuple[Motion, Rig]:
    """Return motion and rig with a pendulum's pivot that moves: lines within the band, of equal acceleration."""
    for law, parameters in _laws(effects):
        if law.carries_joint:
            std, (low, high) = parameters["std"], parameters["band"]
            share = (np.arange(LINES) + rng.uniform(0.3, 0.7, (3, LINES))) / LINES  # apart, so that they beat slowly
            frequency, phase = low + (high - low) * share, rng.uniform(0, 2 * np.pi, (3, LINES))
            amplitude = std * np.sqrt(2 / LINES) / (2 * np.pi * frequency) ** 2
            paths = (Sines(*numbers) for numbers in zip(amplitude, frequency, phase, strict=True))
            return Carried(motion, *paths), replace(rig, pivot_moves=True)
    return motion, rig


def believed(segment: Segment | Body, effects: Sequence[Injected]) -> Body:
    """Return the body that is declared for a swinging segment: lighter or heavier than it is by its effects.

    With them, m l / I is `scale` times what it says. Raises `InputError` where no body has that inertia about its joint
    and the segment's weight.
    """
    inertia, arm = segment.inertia, segment.mass * (segment.com @ segment.com - segment.com**2)
    for law, parameters in _laws(effects):
        if law.acts("lighter"):
            factor = law.lighter({name: Jet(np.array([[float(x)]])) for name, x in parameters.items()})
            scale = 1.0 if factor is None else float(factor.value.ravel()[0])
            inertia = scale * (inertia + arm) - arm
    return Body(segment.mass, segment.com, inertia)


def injected_profile(profile: ImuProfile, at: str, effects: Sequence[Injected]) -> ImuProfile:
    """Return the profile of the sensor `at` with the effects that an IMU model has a number for.

    `profile` gives its noise as `noise_std`. Bias, scale and misalignment come on top of the profile's.
    """
    channels: dict[str, dict[str, Any]] = {"gyro": {}, "accel": {}}
    whole: dict[str, Any] = {}
    for e in (e for e in effects if e["at"] == at):
        name, p = e["effect"], e["parameters"]
        kind = name.split("_")[0]
        if name in SUMMED:
            key, parameter = SUMMED[name]
            channels[kind][key] = getattr(getattr(profile, kind), key) + np.asarray(p[parameter], dtype=float)
        elif name in NOISE:
            channels[kind]["noise_std"] = p["std"]
        elif name in DIGITAL:
            key, parameter = DIGITAL[name]
            for channel in p["channels"]:
                channels[channel][key] = p[parameter]
        elif name == "g_sensitivity":
            whole["g_sensitivity"] = profile.g_sensitivity + np.asarray(p["matrix"])
        elif name in ("time_offset", "clock_skew"):
            whole |= {"clock_offset": p["offset"]} if name == "time_offset" else {"clock_skew": p["skew"]}
        elif name == "dropouts":
            whole |= {"dropout_fraction": p["fraction"], "dropout_mode": p["mode"]}
    changed = {kind: replace(getattr(profile, kind), **numbers) for kind, numbers in channels.items()}
    return replace(profile, **changed, **whole)


def injected_samples(imu: Imu, effects: Sequence[Injected], rng: np.random.Generator) -> Imu:
    """Return an IMU with what the laws of effects that no profile has do to its samples."""
    time, gyro, accel = imu.time, imu.gyro, imu.accel
    for law, parameters in _laws(effects, imu.name):
        if law.name in IN_PROFILE or not law.acts("error", "corrupt"):
            continue
        values = {k: np.asarray(v) for k, v in parameters.items() if np.asarray(v).dtype.kind in "if"}
        if law.acts("error"):
            jets = {k: Jet(np.atleast_1d(v).reshape(1, -1)) for k, v in law.of_report(values, rng).items()}
            error = law.error(Reading(Jet(gyro), Jet(accel), Jet((time - time[0])[:, None])), jets)
            gyro = gyro if error.gyro is None else gyro + error.gyro.value
            accel = accel if error.accel is None else accel + error.accel.value
        else:
            time, gyro, accel = law.corrupt(time, gyro, accel, values, rng)
    changed = time is not imu.time or gyro is not imu.gyro or accel is not imu.accel
    return replace(imu, time=time, gyro=gyro, accel=accel) if changed else imu
