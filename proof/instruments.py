"""The encoder, the measured poses and the reference of a case; they keep the world's time.

The encoder reads the hinge angle; with `backlash` it sits on a side of the joint that follows with free play.
"""

from typing import Any

import numpy as np

from imubench.proof.frames import Track, read_at
from imubench.proof.options import Effect, Options, World, find, stream
from imubench.proof.rotation import Array, exp, to_quaternion
from imubench.proof.unknown import play

ENCODER_NOISE, POSITION_NOISE, ROTATION_NOISE = 5e-4, 1e-3, 4e-3  # rad, m, rad


def read_encoder(world: World, effects: list[Effect], options: Options, seed: int) -> dict[str, Any]:
    """Return the table [[encoder]] and its columns."""
    rng = stream(seed, "encoder")
    time = np.arange(rng.uniform(0, 0.01), options.seconds, 1 / options.rate)
    angle, backlash = world.angle[0], find(effects, "backlash")
    if backlash:
        angle = play(angle, float(backlash["range"]))
    zero, std = round(float(rng.uniform(-0.5, 0.5)), 4), options.noise * ENCODER_NOISE
    read = read_at(time, angle) - zero + std * rng.standard_normal(len(time))
    return {"columns": {"time": time, "angle": read}, "joint": "hinge", "angle_noise_std": std, "zero": zero}


def read_pose(track: Track, segment: str, options: Options, seed: int) -> dict[str, Any]:
    """Return the table [[pose]] of a segment and its columns, unseen now and then."""
    rng = stream(seed, f"pose {segment}")
    time = np.arange(rng.uniform(0, 0.01), options.seconds, 1 / 100.0)
    m = len(time)
    p = read_at(time, track.p) + options.noise * POSITION_NOISE * rng.standard_normal((m, 3))
    R = attitudes(time, track.R) @ exp(options.noise * ROTATION_NOISE * rng.standard_normal((m, 3)))
    q = continuous(to_quaternion(R))
    for _ in range(rng.poisson(options.seconds / 30)):
        start = rng.uniform(0.1, 0.9) * options.seconds
        unseen = (time > start) & (time < start + rng.uniform(0.05, 0.6))
        p[unseen], q[unseen] = np.nan, np.nan
    columns = dict(zip(("time", "x", "y", "z", "qw", "qx", "qy", "qz"), (time, *p.T, *q.T), strict=True))
    return {
        "columns": columns,
        "segment": segment,
        "position_noise_std": options.noise * POSITION_NOISE,
        "rotation_noise_std": options.noise * ROTATION_NOISE,
    }


def reference(world: World, options: Options) -> dict[str, Array]:
    """Return the columns of reference.csv: the true motion of the segments, 100 Hz."""
    time = np.arange(0.0, options.seconds, 0.01)
    columns = {"time": time}
    if options.shape.hinge:
        columns["hinge_angle"] = read_at(time, world.angle[0])
    for i, track in enumerate(world.segments):
        q = continuous(to_quaternion(attitudes(time, track.R)))
        columns |= {f"q{i + 1}_{axis}": q[:, k] for k, axis in enumerate("wxyz")}
    if options.shape.jointed:
        joint = read_at(time, world.segments[-1].p)
        columns |= {f"joint_{axis}": joint[:, k] for k, axis in enumerate("xyz")}
    return columns


def attitudes(time: Array, R: Array) -> Array:
    """Return the attitude (m, 3, 3) at times (m,)."""
    return read_at(time, np.ascontiguousarray(R))


def continuous(q: Array) -> Array:
    """Return quaternions (m, 4) without jumps of sign."""
    flips = np.cumprod(np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0))
    return q * np.concatenate([[1.0], flips])[:, None]
