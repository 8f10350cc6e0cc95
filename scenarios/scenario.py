"""A scenario: a rig, a motion and an IMU, all random by seed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from imubench import rotations
from imubench.sim.imu_model import Declared, DeclaredMount
from imubench.sim.rigs import Mount, Rig
from imubench.truth import Truth


@dataclass(frozen=True)
class Experiment:
    """What happened, and what its owner declares about it."""

    rig: Rig
    truth: Truth
    declared: Declared


@dataclass(frozen=True)
class Scenario:
    """A named experiment that can be repeated with any seed."""

    name: str
    summary: str
    estimator: str | None  # the one that `run` takes by default
    profile: str  # of sim/profiles.toml
    play: Callable[[np.random.Generator], Experiment]


def declared_mounts(
    rig: Rig, rng: np.random.Generator, position_std: float = 0.005, rotation_std: float = 0.02
) -> dict[str, DeclaredMount]:
    """Return the mount poses as an owner would measure them: off by the stds, in m and rad, that he declares."""

    def measured(mount: Mount) -> DeclaredMount:
        position = mount.position + rng.normal(scale=position_std, size=3)
        turned = rotations.multiply(mount.quaternion, rotations.exp(rng.normal(scale=rotation_std, size=3)))
        return DeclaredMount(position, turned, position_std, rotation_std)

    return {f"imu{i + 1}": measured(mount) for i, mount in enumerate(rig.mounts)}
