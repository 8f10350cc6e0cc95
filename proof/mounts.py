"""From a segment to the sensing point of its IMU: the mount, and everything that may be wrong with it.

Translations d are in the segment frame and add up; rotations follow one another on the right:

    q = q_mount exp(mount_pose) exp(mount_shift s(t)) exp(twist angle) exp(rocking)

    mount_pose      constant `rotation`, `translation`
    mount_shift     the same, times a smooth step s(t) of 0.2 s that starts at `time`
    skin_sliding    d = slide * angle and exp(twist * angle), angle: the hinge angle or the pendulum's swing
    soft_mount      see `springs.soft`        rocking_mount   see `springs.rocking`

All of it moves for real: the gyroscope feels the turning, the accelerometer the acceleration.
"""

from dataclasses import dataclass

import numpy as np

from imubench.proof.frames import Track
from imubench.proof.motion import smooth_step
from imubench.proof.options import Effect, Options, World, find, stream
from imubench.proof.rotation import Array, exp, random_rotation, to_quaternion
from imubench.proof.springs import rocking, soft
from imubench.proof.unknown import creep, hardening

SHIFT = 0.2  # s


@dataclass(frozen=True)
class Mount:
    """Where a sensor is, and where the model has it; position (3,) m, rotation (3, 3) sensor -> segment."""

    position: Array
    rotation: Array
    declared_position: Array
    declared_rotation: Array


def random_mount(options: Options, at: str, effects: list[Effect], seed: int) -> Mount:
    """Return a declared mount and the true one, which misses it by the declared stds.

    With `mount_pose` the true one is the declared one, so that its parameters are the whole deviation.
    """
    rng = stream(seed, f"mount {at}")
    side = rng.uniform(-0.04, 0.04, 3)
    shape = options.shape
    if shape.sides:
        side[shape.along] = shape.sides[int(at.removeprefix("imu")) - 1] * rng.uniform(*shape.reach)
    R = random_rotation(rng)
    off, turn = options.position_std * rng.standard_normal(3), options.rotation_std * rng.standard_normal(3)
    if not options.geometry_error or find(effects, "mount_pose", at):
        return Mount(side, R, side, R)
    return Mount(side + off, R @ exp(turn), side, R)


def sensor_track(world: World, segment: Track, mount: Mount, at: str, effects: list[Effect]) -> Track:
    """Return the frame of the sensing element of IMU `at` on its segment."""
    n, zero = len(world.t), np.zeros(3)
    d, d1, d2 = np.broadcast_to(mount.position, (n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
    pose, shift, skin = (find(effects, name, at) for name in ("mount_pose", "mount_shift", "skin_sliding"))
    if pose:
        d = d + np.asarray(pose.get("translation", zero))
    if shift:
        s, s1, s2 = shift_step(world.t, float(shift["time"]))
        by = np.asarray(shift.get("translation", zero))
        d, d1, d2 = d + np.outer(s, by), d1 + np.outer(s1, by), d2 + np.outer(s2, by)
    if skin:
        slide = np.asarray(skin.get("slide", zero), dtype=float)
        d, d1, d2 = (x + np.outer(a, slide) for x, a in zip((d, d1, d2), world.angle, strict=True))
    track = segment.placed(d, d1, d2)
    if sprung := find(effects, "soft_mount", at):
        track = soft(track, sprung)
    if hard := find(effects, "hardening_mount", at):
        track = hardening(track, hard)
    track = track.turned(mount.rotation)
    if pose:
        track = track.turned(exp(pose.get("rotation", zero)))
    if shift:
        track = _along(track, shift.get("rotation", zero), (s, s1, s2))
    if skin:
        track = _along(track, skin.get("twist", zero), world.angle)
    if creeping := find(effects, "creep", at):
        track = _along(track, creeping["rotation"], creep(world.t, float(creeping["time_constant"])))
    if rocks := find(effects, "rocking_mount", at):
        track = rocking(track, rocks)
    return track


def shift_step(t: Array, start: float) -> tuple[Array, Array, Array]:
    """Return how far a mount has shifted at t, 0 to 1, with two derivatives."""
    _, s, s1, s2 = smooth_step((t - start) / SHIFT)
    return s, s1 / SHIFT, s2 / SHIFT**2


def _along(track: Track, rotation: object, amount: tuple[Array, Array, Array]) -> Track:
    """Return the track turned by exp(rotation * amount); about a still axis rates are exact."""
    vector = np.asarray(rotation, dtype=float)
    if not vector.any():
        return track
    return track.turned(exp(np.outer(amount[0], vector)), np.outer(amount[1], vector), np.outer(amount[2], vector))


def declared(options: Options, mount: Mount) -> dict[str, object]:
    """Return what recording.toml says of a mount."""
    says: dict[str, object] = {
        "mount_position": mount.declared_position,
        "mount_quaternion": to_quaternion(mount.declared_rotation),
    }
    if options.declare_geometry:
        says |= {"mount_position_std": options.position_std, "mount_rotation_std": options.rotation_std}
    return says
