"""An independent record of the same motion: it never enters a fit, it only judges one."""

from dataclasses import dataclass

from imubench.arrays import Array, frozen, frozen_time
from imubench.displays import Summarised
from imubench.errors import InputError


@dataclass(frozen=True, repr=False)
class Reference(Summarised):
    """Optical or other records, NaN where unseen. Deliberately not a part of `Recording`."""

    time: Array  # (n,) s
    hinge_angle: Array | None = None  # (n,) rad
    quaternion1: Array | None = None  # (n, 4) segment 1 -> world
    quaternion2: Array | None = None  # (n, 4) segment 2 -> world
    joint_position: Array | None = None  # (n, 3) m, world

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", frozen_time(self.time, "reference.time"))
        n = self.time.size
        shapes = {"hinge_angle": (n,), "quaternion1": (n, 4), "quaternion2": (n, 4), "joint_position": (n, 3)}
        if all(getattr(self, key) is None for key in shapes):
            raise InputError("reference: expected at least one column beside time, got none")
        for key, shape in shapes.items():
            if getattr(self, key) is not None:
                object.__setattr__(self, key, frozen(getattr(self, key), shape, f"reference.{key}", finite=False))
