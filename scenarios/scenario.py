"""A scenario: a rig, a motion and an IMU, all random by seed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from imubench.sim.imu_model import Declared, DeclaredMount
from imubench.sim.rigs import Rig
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


def declared_mounts(rig: Rig, position_std: float = 0.005, rotation_std: float = 0.02) -> dict[str, DeclaredMount]:
    """Return the rig's own mount poses as an owner would declare them, with the stds in m and rad."""
    return {
        f"imu{i + 1}": DeclaredMount(mount.position, mount.quaternion, position_std, rotation_std)
        for i, mount in enumerate(rig.mounts)
    }
