"""What one case's sensors read: the rig moves, the mounts carry, the sensors sample."""

from dataclasses import dataclass

import numpy as np

from imubench.proof.frames import Track, grid
from imubench.proof.free import free
from imubench.proof.hinge import hinge
from imubench.proof.mounts import Mount, random_mount, sensor_track
from imubench.proof.options import Effect, Options, World, find
from imubench.proof.pendulum import pendulum
from imubench.proof.sensors import Samples, read_imu


@dataclass(frozen=True)
class Case:
    """Everything about one case: what is asked, what moved, what the sensors read."""

    options: Options
    seed: int
    effects: list[Effect]
    world: World
    mounts: list[Mount]
    tracks: list[Track]  # of the sensing elements
    imus: list[Samples]

    @property
    def rates(self) -> list[float]:
        """The nominal rates in Hz."""
        return [self.options.rate, self.options.rate2 or self.options.rate][: len(self.imus)]


def played(options: Options, effects: list[Effect], seed: int) -> Case:
    """Return the case of effects whose parameters are all there."""
    return sensed(options, effects, seed, moved(options, effects, grid(options.seconds), seed))


def sensed(options: Options, effects: list[Effect], seed: int, world: World) -> Case:
    """Return the case of effects on a rig that has moved."""
    mounts, tracks, imus = [], [], []
    for i, segment in enumerate(world.segments):
        at, rate = f"imu{i + 1}", (options.rate2 or options.rate) if i else options.rate
        mounts.append(random_mount(options, at, effects, seed))
        tracks.append(sensor_track(world, segment, mounts[-1], at, effects))
        imus.append(read_imu(tracks[-1], at, effects, options, rate, seed))
    return Case(options, seed, effects, world, mounts, tracks, imus)


def moved(options: Options, effects: list[Effect], t: np.ndarray, seed: int) -> World:
    """Return the motion of a rig on the grid t."""
    world = find(effects, "gravity")
    gravity = float(world["g"]) if world else options.gravity
    if options.shape.hinge:
        return hinge(options, effects, t, gravity, seed)
    if options.shape.ball:
        return pendulum(options, effects, t, gravity, seed)
    return free(options, t, gravity, seed)
