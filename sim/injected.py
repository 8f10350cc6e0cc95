"""Named effects put into a simulation: on the mounts, into the IMU profiles, on the samples.

An effect is {"effect": a name of `effects.EFFECTS`, "at": a sensor, "parameters": {name: value}}. What is not for the
sensor that is asked about is passed over. `gravity` is the rig's and is set by whoever plays it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.effects import EFFECTS
from imubench.effects.effect import Reading
from imubench.jets import Jet
from imubench.recording import Body, Imu
from imubench.sim.imu_model import DeclaredMount
from imubench.sim.imu_profile import ImuProfile
from imubench.sim.joints import Play, Stop
from imubench.sim.motion import Carried, Motion
from imubench.sim.rigs import Mount, Rig, Segment, Slip, inertia_about, springs
from imubench.sim.signals import Sines

Injected = Mapping[str, Any]  # {"effect", "at", "parameters"}

SUMMED = {  # effect -> field of a channel's profile, by its parameter: the effect comes on top
    **{f"{kind}_bias": ("bias", "bias") for kind in ("gyro", "accel")},
    **{f"{kind}_scale": ("scale", "scale") for kind in ("gyro", "accel")},
    **{f"{kind}_misalignment": ("misalignment", "matrix") for kind in ("gyro", "accel")},
}
NOISE = {f"{kind}_noise": ("noise_std", "std") for kind in ("gyro", "accel")}  # the effect is the total
DIGITAL = {"low_pass": ("bandwidth", "cutoff"), "saturation": ("range", "limit"), "quantisation": ("step", "step")}
ADDED = ("gyro_drift", "accel_drift", "vibration")  # by the effects' own laws, on the samples
MOUNTED = ("mount_pose", "soft_mount", "rocking_mount")
SLIDING = ("mount_shift", "skin_sliding")
TORQUES: Mapping[str, Mapping[str, str]] = {  # effect -> parameter -> number of the rig
    "viscous_friction": {"c": "damping"},
    "dry_friction": {"t": "dry_friction"},
    "air_drag": {"d": "drag"},
    "joint_spring": {"k": "stiffness", "q0": "spring_angle"},
}
JOINTED = ("joint_play", "axis_coupling", "moving_centre")
BOUNCE, BOUNCE_RATIO = 25.0, 0.3
"""Hz and damping ratio of a limb on an end stop of which nobody says how stiff it is: it stops within some hundredths
of a radian, and knocks a few times."""
LINES = 30  # sines of a moving pivot, along each axis
SWUNG = (*TORQUES, "end_stop", "inertia")
"""The effects that show in free swings alone."""
INJECTED = (
    *SUMMED, *NOISE, *DIGITAL, *ADDED, *MOUNTED, *SLIDING,
    "g_sensitivity", "time_offset", "clock_skew", "dropouts", "impacts", "gravity", "backlash", "moving_pivot",
    *JOINTED, *SWUNG,
)  # fmt: skip
"""The effects that can be played."""


def moved_mount(mount: Mount, at: str, declared: DeclaredMount, effects: Sequence[Injected]) -> Mount:
    """Return the mount of the sensor `at` where it is: with `mount_pose`, so far from where it is declared."""
    for e in effects:
        if e["at"] == at and e["effect"] == "mount_pose":
            turn = rotations.exp(np.asarray(e["parameters"]["rotation"]))
            position = declared.position + np.asarray(e["parameters"]["translation"])
            return replace(mount, position=position, quaternion=rotations.multiply(declared.quaternion, turn))
    return mount


def sprung_mount(mount: Mount, at: str, effects: Sequence[Injected]) -> Mount:
    """Return the mount of the sensor `at` on the springs of its `soft_mount` or `rocking_mount`."""
    for e in effects:
        p = e["parameters"]
        if e["at"] == at and e["effect"] == "soft_mount":
            mount = replace(mount, translation=springs(p["frequency"], p["damping_ratio"]))
        elif e["at"] == at and e["effect"] == "rocking_mount":
            com, lever = (np.asarray(p[key], dtype=float) for key in ("com", "lever"))
            rocking = springs(p["frequency"], p["damping_ratio"])
            mount = replace(mount, rotation=rocking, com=com, lever=lever, gyration=p["gyration"])
    return mount


def sliding_mount(mount: Mount, at: str, effects: Sequence[Injected]) -> Mount:
    """Return the mount of the sensor `at` with its `mount_shift` and its `skin_sliding`."""
    for e in effects:
        p = e["parameters"]
        if e["at"] == at and e["effect"] == "mount_shift":
            mount = replace(mount, slip=Slip(p["time"], p["translation"], p["rotation"]))
        elif e["at"] == at and e["effect"] == "skin_sliding":
            mount = replace(mount, slide=p["slide"], twist=p["twist"])
    return mount


def injected_rig(rig: Rig, declared: Mapping[str, DeclaredMount], effects: Sequence[Injected]) -> Rig:
    """Return the rig with its effects in it: its mounts, its joint, the world's gravity.

    Args:
        rig: as its owner believes it.
        declared: by sensor, where its owner believes the mounts; `mount_pose` is beside that.
        effects: those of other places than a rig are passed over, and so is `moving_pivot`, see `carried`.
    """
    sensors = rig.tree.imus[: len(rig.mounts)]
    mounts = tuple(
        sliding_mount(sprung_mount(moved_mount(mount, at, declared[at], effects), at, effects), at, effects)
        for at, mount in zip(sensors, rig.mounts, strict=True)
    )
    g = next((e["parameters"]["g"] for e in effects if e["effect"] == "gravity"), rig.gravity)
    return jointed(resisting(replace(rig, mounts=mounts, gravity=g), effects), effects)


def resisting(rig: Rig, effects: Sequence[Injected]) -> Rig:
    """Return the rig with the torques of its effects at the joint."""
    for e in effects:
        for parameter, key in TORQUES.get(e["effect"], {}).items():
            rig = replace(rig, **{key: e["parameters"][parameter]})
        if e["effect"] == "joint_spring" and rig.tree.ball is not None:
            rig = replace(rig, spring_conserves=True)  # as a cable does; see `sim.ball`
        if e["effect"] == "end_stop":
            rig = replace(rig, stop=stop_of(rig, e["parameters"]))
    return rig


def stop_of(rig: Rig, parameters: Mapping[str, Any]) -> Stop:
    """Return an end stop; where nobody says how stiff it is, the limb bounces on it at `BOUNCE` Hz."""
    inertia, w = inertia_about(rig, np.eye(3)[1]), 2 * np.pi * BOUNCE
    stiffness = parameters.get("stiffness", inertia * w**2)
    damping = parameters.get("damping", inertia * 2 * BOUNCE_RATIO * w)
    return Stop(float(parameters["angle"]), float(stiffness), float(damping))


def jointed(rig: Rig, effects: Sequence[Injected]) -> Rig:
    """Return the rig whose hinge does what its effects say beside turning."""
    for e in effects:
        p = e["parameters"]
        if e["effect"] == "axis_coupling":
            rig = replace(rig, coupling=np.asarray(p["coupling"], dtype=float))
        elif e["effect"] == "moving_centre":
            rig = replace(rig, centre=np.asarray(p["slide"], dtype=float))
        elif e["effect"] == "joint_play":
            on_springs = p.get("frequency", 0.0), p.get("damping_ratio", 0.0)
            rig = replace(rig, play=Play(p["range"], p["direction"], *on_springs))
    return rig


def carried(motion: Motion, rig: Rig, effects: Sequence[Injected], rng: np.random.Generator) -> tuple[Motion, Rig]:
    """Return motion and rig with the `moving_pivot` of a pendulum: lines within the band, of equal acceleration."""
    for e in effects:
        if e["effect"] == "moving_pivot":
            std, (low, high) = e["parameters"]["std"], e["parameters"]["band"]
            share = (np.arange(LINES) + rng.uniform(0.3, 0.7, (3, LINES))) / LINES  # apart, so that they beat slowly
            frequency, phase = low + (high - low) * share, rng.uniform(0, 2 * np.pi, (3, LINES))
            amplitude = std * np.sqrt(2 / LINES) / (2 * np.pi * frequency) ** 2
            paths = (Sines(*numbers) for numbers in zip(amplitude, frequency, phase, strict=True))
            return Carried(motion, *paths), replace(rig, pivot_moves=True)
    return motion, rig


def believed(segment: Segment | Body, effects: Sequence[Injected]) -> Body:
    """Return the body that is declared for a swinging segment: with `inertia`, m l / I is `scale` times what it says.

    Raises `InputError` where no body has that inertia about its joint and the segment's weight.
    """
    inertia, arm = segment.inertia, segment.mass * (segment.com @ segment.com - segment.com**2)
    for e in effects:
        if e["effect"] == "inertia":
            inertia = e["parameters"]["scale"] * (inertia + arm) - arm
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
    """Return an IMU with what the laws of drift, vibration and impacts add to its samples."""
    time, gyro, accel = imu.time, imu.gyro, imu.accel
    for e in (e for e in effects if e["at"] == imu.name):
        law = EFFECTS[e["effect"]]
        values = {k: np.asarray(v) for k, v in e["parameters"].items() if np.asarray(v).dtype.kind in "if"}
        if e["effect"] in ADDED:
            if e["effect"] == "vibration":
                values = phased(values, rng)
            jets = {k: Jet(np.atleast_1d(v).reshape(1, -1)) for k, v in values.items()}
            error = law.error(Reading(Jet(gyro), Jet(accel), Jet((time - time[0])[:, None])), jets)
            gyro = gyro if error.gyro is None else gyro + error.gyro.value
            accel = accel if error.accel is None else accel + error.accel.value
        elif e["effect"] == "impacts":
            time, gyro, accel = law.corrupt(time, gyro, accel, values, rng)
    changed = time is not imu.time or gyro is not imu.gyro or accel is not imu.accel
    return replace(imu, time=time, gyro=gyro, accel=accel) if changed else imu


def phased(values: Mapping[str, Array], rng: np.random.Generator) -> dict[str, Array]:
    """Return a hum as its law has it: amplitude sin(2 pi f t + phase) of a random phase."""
    phase = rng.uniform(0, 2 * np.pi)
    both = {"cosine": np.sin(phase) * values["amplitude"], "sine": np.cos(phase) * values["amplitude"]}
    return {"frequency": values["frequency"], **both}
