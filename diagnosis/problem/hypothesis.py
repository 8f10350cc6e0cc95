"""What a model is made of: an effect at a place, what is held of a parameter, one trial solution."""

from dataclasses import dataclass

from imubench.arrays import Array
from imubench.effects.effect import Effect


@dataclass(frozen=True)
class Hypothesis:
    """An effect at a place."""

    effect: Effect
    at: str  # imu1, imu2, joint, body, world
    tag: str = ""  # tells grid points of one effect apart while they are scored side by side

    @property
    def name(self) -> str:
        """As it is written: soft_mount@imu2, or low_pass[gyro]@imu1 where a setting is not the usual one."""
        variant = f"[{self.effect.variant}]" if self.effect.variant else ""
        return f"{self.effect.name}{variant}@{self.at}"

    def key(self, part: str) -> str:
        """Return the name of one of its parameters or states in the fit."""
        return f"{self.name}{self.tag}.{part}"


@dataclass(frozen=True)
class Prior:
    """Where a parameter starts and how far it may plausibly go."""

    start: Array  # (k,)
    std: Array  # (k,)


@dataclass(frozen=True)
class State:
    """One trial solution."""

    coefficients: Array  # (count, width)
    values: dict[str, Array]  # parameter -> (k,)


@dataclass(frozen=True)
class Geometry:
    """The mounts that the fit starts from: the declared ones, or estimated where none is declared."""

    position: Array  # (3,) m
    turn: Array  # (3, 3) sensor -> segment


def linear_in(h: Hypothesis) -> bool:
    """Return whether an effect is next to linear in its parameters, and has no states."""
    return not h.effect.states and bool(h.effect.parameters) and not any(p.log for p in h.effect.parameters)


__all__ = ["Geometry", "Hypothesis", "Prior", "State", "linear_in"]
